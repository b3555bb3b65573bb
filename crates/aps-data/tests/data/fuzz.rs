//! Readers fed with array files, .propbin files and samples, random ones and valid ones with bytes changed; manifests are
//! fed in `src/manifest/fuzz.rs`.

use aps_data::npy::{self, Header};
use aps_data::propbin::{Chain, Propbin};
use aps_data::released::Sample;
use proptest::prelude::*;
use proptest::sample::Index;

/// Every way in; whatever the bytes, each returns, and what it returns is no larger than the bytes.
fn read_all_ways(bytes: &[u8]) {
    let _ = Header::read(&mut &bytes[..], bytes.len() as u64);
    if let Ok(array) = npy::from_bytes::<u8>(bytes) {
        assert!(array.data.len() <= bytes.len());
    }
    if let Ok(array) = npy::from_bytes::<half::f16>(bytes) {
        assert!(array.data.len() * 2 <= bytes.len());
    }
    if let Ok(array) = npy::from_bytes::<[f64; 2]>(bytes) {
        assert!(array.data.len() * 16 <= bytes.len());
    }
}

fn npy_file(dictionary: &str, claimed: u16, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend_from_slice(&claimed.to_le_bytes());
    bytes.extend_from_slice(dictionary.as_bytes());
    bytes.extend_from_slice(data);
    bytes
}

fn changed(bytes: &[u8], changes: &[(Index, u8)]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for (at, value) in changes {
        let at = at.index(bytes.len());
        bytes[at] = *value;
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.max(1_000)))]

    #[test]
    fn npy_of_any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        read_all_ways(&bytes);
        read_all_ways(&[b"\x93NUMPY\x01\x00", bytes.as_slice()].concat());
    }

    #[test]
    fn npy_of_any_dictionary(text in "[{}()\\[\\]'\",: a-z0-9<|]{0,80}", data in prop::collection::vec(any::<u8>(), 0..20)) {
        read_all_ways(&npy_file(&text, text.len() as u16, &data));
    }

    #[test]
    fn npy_of_any_shape(shape in prop::collection::vec(any::<u64>(), 0..5), descr in "[<>|][a-z][0-9]{1,2}") {
        let axes: String = shape.iter().map(|n| format!("{n}, ")).collect();
        let text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({axes}), }}\n");
        read_all_ways(&npy_file(&text, text.len() as u16, b"data"));
    }

    #[test]
    fn npy_with_bytes_changed(
        changes in prop::collection::vec((any::<Index>(), any::<u8>()), 1..6),
        cut in any::<Index>(),
    ) {
        let mut bytes = Vec::new();
        npy::write_to(&mut bytes, &[2, 3], &[1_u8, 2, 3, 4, 5, 6]).unwrap();
        let bytes = changed(&bytes, &changes);
        read_all_ways(&bytes);
        read_all_ways(&bytes[..cut.index(bytes.len())]);
    }
}

const FULL: &[u8] = include_bytes!("../../../../tests/golden/released/full.propbin");
const COMPACT: &[u8] = include_bytes!("../../../../tests/golden/released/compact.propbin.gz");
const SAMPLE: &[u8] = include_bytes!("../../../../tests/golden/released/sample.npz");

#[test]
fn unchanged_files_are_read() {
    for bytes in [FULL, COMPACT] {
        assert!(Propbin::from_bytes(bytes).is_ok());
        read_propbin(bytes);
    }
    assert!(Sample::from_npz(SAMPLE).is_ok());
}

/// Checks that the reader returns on any bytes, and that its result is finite and no longer than the bytes.
fn read_propbin(bytes: &[u8]) {
    let Ok(file) = Propbin::from_bytes(bytes) else {
        return;
    };
    let mut paths = 0;
    for receiver in file.receivers() {
        assert!(receiver.position_m.iter().all(|v| v.is_finite()));
        for (path, chain) in file.paths_of(receiver) {
            paths += 1;
            assert!(path.loss_db.is_finite() && path.delay_ns.is_finite());
            let (Chain::Points(_) | Chain::Vertices(_) | Chain::Rooftop(_)) = chain;
            if let Chain::Points(points) = chain {
                assert!(points.as_flattened().iter().all(|v| v.is_finite()));
            }
        }
    }
    assert!(paths <= file.to_bytes().expect("it was small enough to read").len() / 24);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.max(1_000)))]

    #[test]
    fn propbin_with_bytes_changed(
        changes in prop::collection::vec((any::<Index>(), any::<u8>()), 1..6),
        header in prop::collection::vec((0_usize..32, prop::sample::select(vec![0_u8, 1, 2, 3, 4, 255])), 0..2),
        cut in prop::option::weighted(0.1, any::<Index>()),
    ) {
        let mut bytes = changed(FULL, &changes);
        for (at, value) in header {
            bytes[at] = value;
        }
        bytes.truncate(cut.map_or(bytes.len(), |cut| cut.index(bytes.len())));
        read_propbin(&bytes);
    }

    #[test]
    fn compressed_propbin_with_bytes_changed(
        changes in prop::collection::vec((any::<Index>(), any::<u8>()), 1..6),
        inside in any::<bool>(),
    ) {
        thread_local! {
            static PLAIN: Vec<u8> = Propbin::from_bytes(COMPACT).unwrap().to_bytes().unwrap();
        }
        if inside {
            read_propbin(&PLAIN.with(|plain| changed(plain, &changes)));
        } else {
            read_propbin(&changed(COMPACT, &changes));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.max(1_000)))]

    #[test]
    fn sample_with_bytes_changed(
        changes in prop::collection::vec((any::<Index>(), any::<u8>()), 1..6),
        directory in prop::option::of((any::<Index>(), any::<u8>())),
    ) {
        let mut bytes = changed(SAMPLE, &changes[..changes.len() / 2]);
        // Most of what can go wrong is in the directory at the end and in the headers of the arrays.
        if let Some((at, value)) = directory {
            let start = bytes.len() - 160;
            let at = start + at.index(160);
            bytes[at] = value;
        }
        if let Ok(sample) = Sample::from_npz(&bytes) {
            assert!(sample.aps_norm.len() + sample.cond_img.len() < 1 << 16);
        }
    }
}

#[test]
fn claimed_sizes_take_no_memory() {
    // A header of 4 GiB, and a shape of 2^63 elements, in files of a few bytes.
    let long_header = b"\x93NUMPY\x02\x00\xff\xff\xff\xff{}";
    assert!(matches!(
        npy::from_bytes::<u8>(long_header),
        Err(npy::NpyError::HeaderLength { limit: 2, .. })
    ));
    let text = "{'descr': '|u1', 'fortran_order': False, 'shape': (9223372036854775808,)}";
    let huge = npy_file(text, text.len() as u16, b"");
    assert!(matches!(
        npy::from_bytes::<u8>(&huge),
        Err(npy::NpyError::Length { .. })
    ));
}

#[test]
fn nested_brackets_exhaust_nothing() {
    let text = "(".repeat(9_000);
    assert!(npy::from_bytes::<u8>(&npy_file(&text, 9_000, b"")).is_err());
}
