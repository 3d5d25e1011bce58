//! Tests of the monitors that formulas get, against the definition of LTL.

mod enumeration;
mod patterns;
mod words;
