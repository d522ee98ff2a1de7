#![no_main]

use dgd_fuzz::documents;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| -> libfuzzer_sys::Corpus {
    dgd_fuzz::run_document(bytes, documents::well)
});
