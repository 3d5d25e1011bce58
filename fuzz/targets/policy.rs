#![no_main]

use meliora_fuzz::entry;

libfuzzer_sys::fuzz_target!(|text: &str| entry::policy(text));
