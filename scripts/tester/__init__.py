"""The tester: random cases that draw all features at once, and every answer of the program against the reference."""
