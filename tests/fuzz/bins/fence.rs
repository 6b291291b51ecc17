//! The libFuzzer program for [`backseat_fuzz::fence`].
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| backseat_fuzz::fence(data));
