#![no_main]

use dgd_ingest::Format;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| -> libfuzzer_sys::Corpus {
    dgd_fuzz::run_recording(bytes, Format::Csv)
});
