"""The reference: SEMANTICS, written down over explicit sets and fractions. It shares nothing with the program."""
