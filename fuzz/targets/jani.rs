#![no_main]

#[path = "../../tests/common/entry.rs"]
mod entry;

libfuzzer_sys::fuzz_target!(|text: &str| entry::jani(text));
