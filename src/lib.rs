//! Meliora: a symbolic model checker for opportunistic planning with incomplete preferences.
