#![no_main]

#[path = "../../tests/common/entry.rs"]
mod entry;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| entry::values(bytes));
