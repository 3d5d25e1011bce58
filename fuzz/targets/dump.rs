#![no_main]

use meliora_fuzz::entry;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| entry::dump(bytes));
