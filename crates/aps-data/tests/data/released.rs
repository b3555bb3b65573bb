//! The published data's formats against files written by NumPy and by Python's struct.

use aps_data::npy;
use aps_data::propbin::{Chain, Direction, Path, Propbin, PropbinError, Version};
use aps_data::released::{ProfileFile, Sample, SampleError};
use proptest::prelude::*;
use serde_json::Value;

macro_rules! golden {
    ($name:literal) => {
        include_bytes!(concat!("../../../../tests/golden/released/", $name))
    };
}

#[test]
fn profiles_are_the_bytes_numpy_writes() {
    for (values, file) in [
        (&golden!("aps.json")[..], &golden!("aps.npy")[..]),
        (golden!("pdp.json"), golden!("pdp.npy")),
    ] {
        let values: Value = serde_json::from_slice(values).unwrap();
        let column = |name: &str| -> Vec<f64> {
            let numbers = values[name].as_array().unwrap();
            numbers.iter().map(|v| v.as_f64().unwrap()).collect()
        };
        let profile = ProfileFile::rounded(&column("db"), &column("place"));
        assert_eq!(profile.to_bytes(), file);
        assert_eq!(ProfileFile::from_bytes(file).unwrap(), profile);
        assert!(profile.is_finite() && !profile.is_all_zero());
    }
}

#[test]
fn profile_of_another_shape_is_refused() {
    let mut bytes = Vec::new();
    npy::write_to(&mut bytes, &[6], &[half::f16::ONE; 6]).unwrap();
    assert!(ProfileFile::from_bytes(&bytes).is_err());
}

#[test]
fn sample_of_numpy_is_read() {
    let sample = Sample::from_npz(golden!("sample.npz")).unwrap();
    assert_eq!((sample.aps_norm.len(), sample.size), (180, [8, 4]));
    let expected: Vec<f32> = (0..96).map(|i| (f64::from(i) / 96.0) as f32).collect();
    assert_eq!(sample.cond_img, expected);
    assert_eq!(Sample::from_npz(&sample.to_npz().unwrap()).unwrap(), sample);
}

#[test]
fn bad_samples_are_told_apart() {
    let sample = Sample::from_npz(golden!("sample.npz")).unwrap();
    let transposed = Sample {
        size: [8, 5],
        ..sample.clone()
    };
    assert!(matches!(transposed.to_npz(), Err(SampleError::Npy { .. })));
    let not_finite = Sample {
        aps_norm: vec![f32::NAN],
        ..sample
    };
    let bytes = not_finite.to_npz().unwrap();
    assert!(matches!(
        Sample::from_npz(&bytes),
        Err(SampleError::NotFinite { array: "aps_norm" })
    ));
    assert!(matches!(
        Sample::from_npz(&bytes[..bytes.len() - 1]),
        Err(SampleError::Zip(_))
    ));
}

/// The archive of a sample with its bytes changed.
fn archive(change: impl FnOnce(&mut Vec<u8>)) -> SampleError {
    let sample = Sample::from_npz(golden!("sample.npz")).unwrap();
    let mut bytes = sample.to_npz().unwrap();
    change(&mut bytes);
    Sample::from_npz(&bytes).unwrap_err()
}

/// Replaces a text wherever it stands by one of the same length.
fn replace(bytes: &mut [u8], old: &[u8], new: &[u8]) {
    for at in 0..=bytes.len() - old.len() {
        if bytes[at..].starts_with(old) {
            bytes[at..at + old.len()].copy_from_slice(new);
        }
    }
}

/// A number of an array that is not compressed, changed by the last bit of its mantissa, is a number as good as before.
#[test]
fn a_changed_bit_of_an_array_is_found_by_its_checksum() {
    let whole = Sample::from_npz(golden!("sample.npz")).unwrap();
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, shape, data) in [
        ("aps_norm.npy", &[180][..], &whole.aps_norm),
        ("cond_img.npy", &[3, 8, 4], &whole.cond_img),
    ] {
        zip.start_file(name, options).unwrap();
        npy::write_to(&mut zip, shape, data).unwrap();
    }
    let bytes = zip.finish().unwrap().into_inner();
    assert_eq!(Sample::from_npz(&bytes).unwrap(), whole);
    for value in [whole.aps_norm[90], whole.cond_img[95]] {
        let value = value.to_le_bytes();
        let at = bytes.windows(4).rposition(|four| four == value).unwrap();
        let mut changed = bytes.clone();
        changed[at] ^= 1;
        let told = Sample::from_npz(&changed).unwrap_err();
        assert!(matches!(told, SampleError::Zip(_)), "{told}");
    }
}

#[test]
fn a_missing_array_is_named_with_those_that_are_there() {
    let error = archive(|bytes| replace(bytes, b"aps_norm.npy", b"arr_0.npy\0\0\0"));
    assert!(matches!(
        &error,
        SampleError::Missing {
            array: "aps_norm",
            ..
        }
    ));
    let told = error.to_string();
    for word in ["aps_norm.npy", "arr_0.npy", "cond_img.npy", "numpy.savez("] {
        assert!(told.contains(word), "{told}");
    }
}

#[test]
fn a_compression_that_is_not_read_is_named() {
    // The method stands after signature, version and flags, in the central directory after one version more.
    let error = archive(|bytes| {
        for at in 0..bytes.len() - 12 {
            let method = match &bytes[at..at + 4] {
                b"PK\x03\x04" => at + 8,
                b"PK\x01\x02" => at + 10,
                _ => continue,
            };
            bytes[method..method + 2].copy_from_slice(&14_u16.to_le_bytes());
        }
    });
    assert!(
        matches!(
            &error,
            SampleError::Compression {
                array: "aps_norm",
                ..
            }
        ),
        "{error}"
    );
    assert!(error.to_string().to_lowercase().contains("lzma"), "{error}");
    assert!(
        error.to_string().contains("numpy.savez_compressed"),
        "{error}"
    );
}

/// The paths of the golden files, which half precision holds exactly.
fn golden_paths() -> [Path; 3] {
    [
        path([61.5, 20.0, 66.75, 0.0, 0.0, 0.0, 0.0]),
        path([80.25, 35.5, 118.5, 1.25, 0.5, -2.5, -0.5]),
        path([95.0, 50.0, 166.75, -1.5, 0.25, 3.0, 0.125]),
    ]
}

/// A path of loss, length, delay, and azimuth and elevation of departure and of arrival.
fn path(v: [f32; 7]) -> Path {
    let direction = |azimuth_rad, elevation_rad| Direction {
        azimuth_rad,
        elevation_rad,
    };
    Path {
        loss_db: v[0],
        length_m: v[1],
        delay_ns: v[2],
        departure: direction(v[3], v[4]),
        arrival: direction(v[5], v[6]),
    }
}

#[track_caller]
fn check_golden(file: &Propbin, version: Version) {
    assert_eq!(
        (file.version(), file.source_m()),
        (version, [10.0, 20.0, 1.5])
    );
    let [first, second] = file.receivers() else {
        panic!("two receivers")
    };
    assert_eq!((first.id, first.position_m), (7, [30.0, 20.0, 1.5]));
    let totals = [first, second].map(|receiver| (receiver.total_power_dbm, receiver.total_loss_db));
    assert_eq!(totals, [(Some(-60.5), Some(61.5)), (None, None)]);
    assert_eq!(second.id, -1);
    let paths: Vec<Path> = file.paths_of(first).map(|(path, _)| *path).collect();
    assert_eq!(paths, golden_paths());
    assert_eq!(file.paths_of(second).count(), 0);
    assert_eq!(file.unusable_paths(), 0);
}

/// Chains of the paths to the first receiver.
fn chains(file: &Propbin) -> Vec<Chain<'_>> {
    let paths = file.paths_of(&file.receivers()[0]);
    paths.map(|(_, chain)| chain).collect()
}

#[test]
fn full_propbin_is_read_and_written_alike() {
    let bytes = golden!("full.propbin");
    let file = Propbin::from_bytes(bytes).unwrap();
    check_golden(&file, Version::Full);
    let lengths = chains(&file).into_iter().map(|chain| match chain {
        Chain::Points(points) => points.len(),
        _ => panic!("points"),
    });
    assert_eq!(lengths.collect::<Vec<_>>(), [2, 3, 4]);

    let mut written = Propbin::new(Version::Full, file.source_m());
    for receiver in file.receivers() {
        written.add_receiver(
            receiver.id,
            receiver.position_m,
            receiver.total_power_dbm,
            receiver.total_loss_db,
        );
        for (path, chain) in file.paths_of(receiver) {
            written.add_path(path, &chain).unwrap();
        }
    }
    // The golden file has infinities where nothing arrives, ours NaN: equal but for these eight bytes.
    let written = written.to_bytes().unwrap();
    let differing: Vec<usize> = (0..bytes.len())
        .filter(|&i| written[i] != bytes[i])
        .collect();
    assert!(
        differing.iter().all(|i| (80..88).contains(i)),
        "{differing:?}"
    );
    assert_eq!(Propbin::from_bytes(&written).unwrap(), file);
}

#[test]
fn compact_propbin_is_read_compressed() {
    let file = Propbin::from_bytes(golden!("compact.propbin.gz")).unwrap();
    check_golden(&file, Version::Compact);
    let expected = [
        Chain::Vertices((&[]).into()),
        Chain::Vertices((&[3, 700]).into()),
        Chain::Rooftop((&[[14.5, 21.0], [25.0, 20.5]]).into()),
    ];
    assert_eq!(chains(&file), expected);
    assert_eq!(
        Propbin::from_bytes(&file.to_bytes().unwrap()).unwrap(),
        file
    );
    assert_eq!(Propbin::from_bytes(&file.to_gzip().unwrap()).unwrap(), file);
}

#[test]
fn name_does_not_decide_about_compression() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("source_0.propbin.gz");
    std::fs::write(&path, golden!("full.propbin")).unwrap();
    check_golden(&Propbin::read(&path).unwrap(), Version::Full);
}

#[test]
fn faults_of_propbin_are_named() {
    let bytes = golden!("full.propbin").to_vec();
    let read = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = bytes.clone();
        change(&mut bytes);
        Propbin::from_bytes(&bytes).unwrap_err()
    };
    assert!(matches!(read(&|b| b[0] = 0), PropbinError::Magic { .. }));
    assert!(matches!(
        read(&|b| b[4] = 3),
        PropbinError::Version { found: 3 }
    ));
    assert!(matches!(
        read(&|b| b.truncate(20)),
        PropbinError::Length {
            expected: 32,
            found: 20
        }
    ));
    assert!(matches!(
        read(&|b| b.truncate(b.len() - 1)),
        PropbinError::Length { .. }
    ));
    assert!(matches!(read(&|b| b.push(0)), PropbinError::Length { .. }));
    // Sizes that are only claimed.
    assert!(matches!(
        read(&|b| b[20..32].fill(0xff)),
        PropbinError::TooLarge { .. }
    ));
    let entry = |error| match error {
        PropbinError::Entry { what, index, .. } => (what, index),
        other => panic!("{other}"),
    };
    // The second receiver claims the first one's paths, or paths beyond the last.
    assert_eq!(entry(read(&|b| b[88] = 1)), ("receiver", 1));
    assert_eq!(entry(read(&|b| b[60] = 1)), ("receiver", 0));
    assert_eq!(entry(read(&|b| b[39] = 0x7f)), ("receiver", 0));
    assert_eq!(entry(read(&|b| b[10..12].fill(0xff))), ("source", 0));
    // The first receiver claims two of its three paths.
    assert_eq!(entry(read(&|b| b[56] = 2)), ("path", 2));
    let chain = 96 + 36 + 28;
    assert_eq!(entry(read(&|b| b[chain] = 200)), ("path", 1));
}

#[test]
fn path_that_is_not_a_number_is_passed_over_and_counted() {
    let mut bytes = golden!("full.propbin").to_vec();
    bytes[96 + 36..96 + 40].copy_from_slice(&f32::NAN.to_le_bytes());
    let file = Propbin::from_bytes(&bytes).unwrap();
    assert_eq!(file.unusable_paths(), 1);
    assert_eq!(file.paths_of(&file.receivers()[0]).count(), 2);
}

#[test]
fn chain_of_another_version_is_refused() {
    let mut file = Propbin::new(Version::Full, [0.0; 3]);
    let [path, ..] = golden_paths();
    assert!(file.add_path(&path, &Chain::Points((&[]).into())).is_err());
    file.add_receiver(0, [1.0; 3], None, None);
    assert!(
        file.add_path(&path, &Chain::Vertices((&[1]).into()))
            .is_err()
    );
}

proptest! {
    #[test]
    fn what_is_written_is_what_is_read(
        values in prop::collection::vec((any::<[i16; 7]>(), prop::collection::vec(any::<[i16; 3]>(), 0..5)), 0..20),
        per_receiver in 1_usize..7,
    ) {
        let mut file = Propbin::new(Version::Full, [1.0, 2.0, 3.0]);
        for (i, (v, chain)) in values.iter().enumerate() {
            if i % per_receiver == 0 {
                file.add_receiver(i as i32, [i as f32, 0.5, 1.5], None, Some(80.0));
            }
            let path = path(v.map(|v| f32::from(v) / 64.0));
            let points: Vec<[f32; 3]> = chain.iter().map(|p| p.map(f32::from)).collect();
            file.add_path(&path, &Chain::Points(points.into())).unwrap();
        }
        let bytes = file.to_bytes().unwrap();
        prop_assert_eq!(Propbin::from_bytes(&bytes).unwrap(), file);
    }
}
