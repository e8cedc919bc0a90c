//! A table of numbers, as text or as a NumPy array. Its values are finite and fill its rows, or its
//! fault is reported in words.

#![no_main]

use libfuzzer_sys::fuzz_target;
use stickslip_cli::table::{parse, parse_record};

fuzz_target!(|bytes: &[u8]| {
    for dt in [None, Some(0.1)] {
        match parse("fuzz".to_owned(), bytes, &[], dt) {
            Ok(table) => {
                assert!(!table.names.is_empty());
                assert_eq!(table.values.len() % table.names.len(), 0);
                assert!(table.values.iter().all(|value| value.is_finite()));
                assert!(table.dt.is_finite());
            }
            Err(fault) => assert!(!fault.to_string().is_empty()),
        }
    }
    for wanted in [&["2"][..], &["x", "1"]] {
        match parse_record("fuzz", bytes, wanted, None) {
            Ok(record) => {
                assert!(record.times.iter().all(|time| time.is_finite()));
                for column in &record.columns {
                    assert_eq!(column.len(), record.times.len());
                }
            }
            Err(fault) => assert!(!fault.to_string().is_empty()),
        }
    }
});
