//! The libFuzzer program for [`backseat_fuzz::frame`].
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| backseat_fuzz::frame(data));
