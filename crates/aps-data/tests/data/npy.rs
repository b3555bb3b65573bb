use std::io::Cursor;

use aps_data::npy::{self, Header, NpyError, Writer};
use half::f16;
use npyz::WriterBuilder;
use proptest::prelude::*;

#[test]
fn header_is_that_of_np_save() {
    // numpy 2.4: np.save of np.zeros((50000, 180), "<f2"), up to the first element.
    let text = "{'descr': '<f2', 'fortran_order': False, 'shape': (50000, 180), }";
    let mut expected = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    expected.extend_from_slice(text.as_bytes());
    expected.resize(127, b' ');
    expected.push(b'\n');
    assert_eq!(Header::bytes_for("<f2", &[50_000, 180]), expected);
}

#[test]
fn number_and_vector_have_shapes_of_their_own() {
    for shape in [vec![], vec![1], vec![1, 1]] {
        let mut bytes = Vec::new();
        npy::write_to(&mut bytes, &shape, &[7.0_f64]).unwrap();
        assert_eq!(npy::from_bytes::<f64>(&bytes).unwrap().shape, shape);
    }
}

#[test]
fn headers_of_other_writers_are_read() {
    let readable = [
        "{\"shape\":(2,),\"descr\":\"|u1\",\"fortran_order\":False}",
        "{'descr': '|u1', 'fortran_order': True, 'shape': (2,)}\n",
        "{'descr': '|u1', 'fortran_order': False, 'shape': (2L,)}\n",
    ];
    let refused = [
        "{'descr': '|u1', 'fortran_order': True, 'shape': (1, 2)}\n",
        "{'descr': '|u1', 'fortran_order': False, 'shape': (L,)}\n",
        "{'descr': '|u1', 'fortran_order': False, 'shape': (2LL,)}\n",
        "{'descr': [('a', '|u1')], 'fortran_order': False, 'shape': (2,)}\n",
        "{'descr': '|u1', 'fortran_order': False, 'shape': (2,)} + x\n",
        "{'descr': '|u1', 'fortran_order': False}\n",
        "{'descr': '|u1', 'descr': '|u1', 'fortran_order': False, 'shape': (2,)}\n",
    ];
    let readable = readable.map(|text| (text, true));
    let refused = refused.map(|text| (text, false));
    for (text, is_readable) in readable.into_iter().chain(refused) {
        for version in [1_u8, 2, 3] {
            let mut bytes = b"\x93NUMPY".to_vec();
            bytes.extend_from_slice(&[version, 0]);
            let length = (text.len() as u32).to_le_bytes();
            bytes.extend_from_slice(if version == 1 { &length[..2] } else { &length });
            bytes.extend_from_slice(text.as_bytes());
            bytes.extend_from_slice(&[3, 4]);
            let array = npy::from_bytes::<u8>(&bytes);
            assert_eq!(array.is_ok(), is_readable, "{text}: {array:?}");
            assert!(array.is_err() || array.unwrap().data == [3, 4]);
        }
    }
}

/// A file of version 1.0 with such a header and such bytes after it.
fn file(header: &str, bytes: &[u8]) -> Vec<u8> {
    let length = (header.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), bytes].concat()
}

/// The refusal of a file of two f32 with such a description of the elements.
fn refusal_of(descr: &str) -> String {
    let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (2,)}}");
    npy::from_bytes::<f32>(&file(&header, &[0; 8]))
        .unwrap_err()
        .to_string()
}

#[test]
fn floats_without_a_byte_order_are_those_of_the_usual_machine() {
    for descr in ["'f4'", "'=f4'", "'<f4'"] {
        let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (1,)}}");
        let array = npy::from_bytes::<f32>(&file(&header, &1.5_f32.to_le_bytes()));
        assert_eq!(array.unwrap().data, [1.5], "{descr}");
    }
    assert!(refusal_of("'>f4'").contains("convert with NumPy's astype"));
}

#[test]
fn what_numpy_cannot_cast_is_to_be_cast_before_it_is_saved() {
    for descr in ["'<V2'", "'|V2'"] {
        let told = refusal_of(descr);
        assert!(told.contains("bfloat16"), "{told}");
        assert!(told.contains("array.astype(np.float32)"), "{told}");
        assert!(told.contains("view(np.uint16)"), "{told}");
    }
    let told = refusal_of("'|V1'");
    assert!(told.contains("before saving"), "{told}");
    let told = refusal_of("'<c8'");
    assert!(told.contains("np.abs"), "{told}");
}

#[test]
fn records_are_named_as_such() {
    let told = refusal_of("[('a', '<f4'), ('b', '<f4')]");
    assert!(told.contains("[('a', '<f4'), ('b', '<f4')]"), "{told}");
    assert!(told.contains("save one field"), "{told}");
    for rest in ["[", "[(", "('<f4', (2,))", "[[[[]"] {
        assert!(refusal_of(rest).contains("records"), "{rest}");
    }
    let many = format!("[{}]", "('longer than a line', '<f4'), ".repeat(100));
    assert!(refusal_of(&many).len() < 200);
}

#[test]
fn two_arrays_in_one_file_are_not_a_truncated_one() {
    let mut bytes = Vec::new();
    npy::write_to(&mut bytes, &[2], &[1.0_f32, 2.0]).unwrap();
    let one = bytes.clone();
    npy::write_to(&mut bytes, &[3], &[1.0_f32; 3]).unwrap();
    let error = npy::from_bytes::<f32>(&bytes).unwrap_err();
    let extra = (bytes.len() - one.len()) as u64;
    assert!(matches!(&error, NpyError::Longer { extra: found, .. } if *found == extra));
    assert!(error.to_string().contains("more than one array"), "{error}");
    let cut = npy::from_bytes::<f32>(&one[..one.len() - 1]).unwrap_err();
    assert!(cut.to_string().contains("truncated"), "{cut}");
}

#[test]
fn an_archive_is_told_apart_from_other_files() {
    let archive = npy::from_bytes::<f32>(b"PK\x03\x04 and what follows in an archive");
    assert!(matches!(archive, Err(NpyError::Archive)));
    let text = npy::from_bytes::<f32>(b"1.0, 2.0, 3.0, 4.0");
    assert!(matches!(text, Err(NpyError::NotNpy)));
}

#[test]
fn writing_less_than_the_shape_is_an_error() {
    assert!(matches!(
        npy::write_to(&mut Vec::new(), &[3], &[1_u8]),
        Err(NpyError::Length { .. })
    ));
    let mut writer = Writer::new(Cursor::new(Vec::new()), "|u1", &[2]).unwrap();
    writer.push(&[1_u8, 2, 3]).unwrap();
    assert!(matches!(writer.finish(), Err(NpyError::Length { .. })));
}

/// A disk with room for so many bytes.
#[derive(Debug)]
struct SmallDisk {
    disk: Cursor<Vec<u8>>,
    room: usize,
}

impl std::io::Write for SmallDisk {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if bytes.len() > self.room {
            return Err(std::io::ErrorKind::StorageFull.into());
        }
        self.room -= bytes.len();
        self.disk.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl std::io::Seek for SmallDisk {
    fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
        self.disk.seek(to)
    }
}

#[test]
fn full_disk_is_an_error_wherever_it_happens() {
    let write = |room| {
        let disk = Cursor::new(Vec::new());
        let mut writer = Writer::new(SmallDisk { disk, room }, "<f8", &[])?;
        writer.push(&[1.0_f64; 4])?;
        writer.finish().map(|(sink, _)| sink.disk.into_inner())
    };
    let bytes = write(1000).unwrap();
    let needed = bytes.len() + 128; // the header is written twice
    assert!(npy::from_bytes::<f64>(&bytes).is_ok());
    assert!(write(needed).is_ok());
    for room in 0..needed {
        assert!(matches!(write(room), Err(NpyError::Io(_))), "{room}");
    }
}

proptest! {
    #[test]
    fn array_grown_by_rows_is_the_array_written_at_once(rows in prop::collection::vec(any::<[u32; 3]>(), 0..9)) {
        let mut at_once = Vec::new();
        npy::write_to(&mut at_once, &[rows.len(), 3], rows.as_flattened()).unwrap();
        let mut writer = Writer::new(Cursor::new(Vec::new()), "<u4", &[3]).unwrap();
        for row in &rows {
            writer.push(row).unwrap();
        }
        let (sink, count) = writer.finish().unwrap();
        prop_assert_eq!((sink.into_inner(), count), (at_once, rows.len()));
    }

    #[test]
    fn independent_reader_sees_what_we_wrote(values in prop::collection::vec(any::<f64>(), 0..40)) {
        let halves: Vec<f16> = values.iter().copied().map(f16::from_f64).collect();
        let mut bytes = Vec::new();
        npy::write_to(&mut bytes, &[halves.len()], &halves).unwrap();
        let read: Vec<f16> = npyz::NpyFile::new(&bytes[..]).unwrap().into_vec().unwrap();
        let bits = |values: &[f16]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&read), bits(&halves));
    }

    #[test]
    fn we_see_what_an_independent_writer_wrote(values in prop::collection::vec(any::<u64>(), 0..40), columns in 1_usize..4) {
        let rows = values.len() / columns;
        let values = &values[..rows * columns];
        let mut bytes = Vec::new();
        let options = npyz::WriteOptions::new().default_dtype().shape(&[rows as u64, columns as u64]);
        let mut writer = options.writer(&mut bytes).begin_nd().unwrap();
        writer.extend(values.iter().copied()).unwrap();
        writer.finish().unwrap();
        let array = npy::from_bytes::<u64>(&bytes).unwrap();
        prop_assert_eq!(array.shape, [rows, columns]);
        prop_assert_eq!(array.data, values);
    }
}

#[test]
fn rows_of_a_file_are_those_of_the_whole() {
    let root = tempfile::tempdir().unwrap();
    let file = root.path().join("a.npy");
    let values: Vec<f32> = (0..24).map(|i| i as f32).collect();
    npy::write(&file, &[4, 3, 2], &values).unwrap();
    for rows in [0..0, 0..1, 1..3, 3..4, 0..4, 4..4] {
        let found = npy::read_rows::<f32>(&file, rows.clone()).unwrap();
        assert_eq!(found.shape, [4, 3, 2]);
        assert_eq!(found.data, values[6 * rows.start..6 * rows.end]);
    }
    let beyond = npy::read_rows::<f32>(&file, 3..5);
    assert!(matches!(beyond, Err(NpyError::Length { .. })));
    assert!(npy::read_rows::<f64>(&file, 0..1).is_err());
    for shape in [vec![], vec![0], vec![0, 3]] {
        let values = vec![1.0_f32; shape.iter().product()];
        npy::write(&file, &shape, &values).unwrap();
        assert!(npy::read_rows::<f32>(&file, 0..1).is_err());
        assert_eq!(
            npy::read_rows::<f32>(&file, 0..0).unwrap().data,
            Vec::<f32>::new()
        );
    }
}
