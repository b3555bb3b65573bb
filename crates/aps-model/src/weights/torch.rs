//! Archives of `torch.save`: a ZIP file with a pickle (`data.pkl`) that describes tensors, and a file of raw values for
//! each storage they view (`data/0`, `data/1`, ...).

use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::{Cursor, Read};
use std::sync::{Mutex, PoisonError};

use candle_core::{DType, Device, Tensor};
use zip::ZipArchive;

use super::names::listed;
use super::pickle::{Id, Node, Pickle};

/// Levels of dictionaries that are looked through: a checkpoint, its parts, and theirs.
const LEVELS: usize = 3;

/// Longest name of a dictionary that is looked through, which begins the names of its tensors, of a storage, and of something else in
/// a message \[bytes\]. Entries may share one text and one description, so each copies a bounded part of them.
const LONGEST_KEY: usize = 64;

/// Longest name of a tensor in its dictionary \[bytes\].
const LONGEST_NAME: usize = 256;

/// Memory of names and sizes that a description may take, in parts of its own length.
const BYTES_A_BYTE: usize = 8;

/// Most dimensions of a tensor.
const MOST_DIMENSIONS: usize = 16;

/// Function that a pickle calls to make a tensor.
const REBUILD_TENSOR: &str = "torch._utils _rebuild_tensor_v2";

/// An open archive. Sizes it states are never trusted with memory: an entry is read up to the length of the file, and a
/// tensor has no more elements than its storage.
pub(super) struct Archive {
    // Reading an entry moves a position.
    zip: Mutex<ZipArchive<Cursor<Vec<u8>>>>,
    /// Prefix of the names of entries, as it stands before `data.pkl`.
    folder: String,
    length: u64,
}

/// Entries of a pickle's dictionaries, by names that are joined by dots: `model_state_dict.conv1.weight`.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Entries {
    pub tensors: BTreeMap<String, TensorRecord>,
    /// Entries that are no tensors, or such as cannot be read, with the reason.
    pub others: Vec<String>,
}

/// A tensor as described by the pickle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TensorRecord {
    pub shape: Vec<usize>,
    pub dtype: DType,
    strides: Vec<usize>,
    /// First element in the storage.
    offset: usize,
    storage: String,
}

impl Archive {
    pub(super) fn new(bytes: Vec<u8>) -> Result<Self, String> {
        let length = bytes.len() as u64;
        let zip = ZipArchive::new(Cursor::new(bytes));
        let zip = zip.map_err(|e| format!("it is no whole archive: {e}"))?;
        let pickle = zip
            .file_names()
            .filter_map(Result::ok)
            .find(|name| *name == "data.pkl" || name.ends_with("/data.pkl"))
            .ok_or("the archive has no data.pkl: it was not written by torch.save")?;
        let folder = pickle.trim_end_matches("data.pkl").to_owned();
        Ok(Self {
            zip: Mutex::new(zip),
            folder,
            length,
        })
    }

    fn read(&self, entry: &str) -> Result<Vec<u8>, String> {
        let name = format!("{}{entry}", self.folder);
        let mut zip = self.zip.lock().unwrap_or_else(PoisonError::into_inner);
        let file = zip.by_name(&name).map_err(|e| format!("{name}: {e}"))?;
        let mut bytes = Vec::new();
        file.take(self.length)
            .read_to_end(&mut bytes)
            .map_err(|e| format!("{name}: {e}"))?;
        Ok(bytes)
    }

    /// Lists the tensors of the archive and its other entries.
    pub(super) fn entries(&self) -> Result<Entries, String> {
        // Old archives do not say; they are little-endian as well.
        if self.read("byteorder").is_ok_and(|order| order != b"little") {
            return Err("its values are big-endian, which is not supported".to_owned());
        }
        describe(&self.read("data.pkl")?)
    }

    /// The values of a tensor.
    pub(super) fn tensor(&self, record: &TensorRecord) -> Result<Tensor, String> {
        let bytes = self.read(&format!("data/{}", record.storage))?;
        let size = record.dtype.size_in_bytes();
        let available = bytes.len() / size;
        let (shape, strides, offset) = (&record.shape, &record.strides, record.offset);
        let count = shape.iter().try_fold(1_usize, |n, &d| n.checked_mul(d));
        let mut pairs = shape.iter().zip(strides);
        let last = pairs.try_fold(offset, |at, (&n, &stride)| {
            n.saturating_sub(1).checked_mul(stride)?.checked_add(at)
        });
        let (Some(count), Some(last)) = (count, last) else {
            return Err(format!("sizes {shape:?} and strides {strides:?} overflow"));
        };
        if count > available || (count > 0 && last >= available) {
            return Err(format!(
                "{shape:?} elements with strides {strides:?} from {offset} do not fit the {available} stored"
            ));
        }
        let mut values = Vec::with_capacity(count * size);
        gather(&bytes, record, size, &mut values);
        Tensor::from_raw_buffer(&values, record.dtype, &record.shape, &Device::Cpu)
            .map_err(|e| e.to_string())
    }
}

/// Lists the tensors and other entries in the dictionaries of a pickle.
fn describe(bytes: &[u8]) -> Result<Entries, String> {
    let pickle = Pickle::parse(bytes).map_err(|e| format!("data.pkl: {e}"))?;
    let root = dict(&pickle, pickle.root)
        .ok_or("it holds no dictionary; save the state_dict() of a model, not the model")?;
    let mut entries = Entries::default();
    // Each dictionary once, however often it is used.
    let mut seen = HashSet::from([pickle.root]);
    let (mut parts, mut unnamed) = (vec![(String::new(), 1, root)], 0);
    // Entries share texts and sizes in the file, but not here.
    let mut left = (1 << 20) + BYTES_A_BYTE * bytes.len();
    while let Some((prefix, level, (items, without))) = parts.pop() {
        unnamed += without;
        for (key, id) in items {
            let name = format!("{prefix}{key}");
            if let Node::Dict(_) = pickle.get(id) {
                let looked_through = level < LEVELS && key.len() <= LONGEST_KEY && seen.insert(id);
                if looked_through && let Some(inner) = dict(&pickle, id) {
                    parts.push((name + ".", level + 1, inner));
                }
                continue;
            }
            let found = record(&pickle, id);
            let sizes = match &found {
                Ok(Some(record)) => record.shape.len(),
                _ => 0,
            };
            let more = name.len() + 2 * size_of::<usize>() * sizes;
            left = left
                .checked_sub(more)
                .ok_or("its entries share so much that it describes more than it can hold")?;
            match found {
                Ok(Some(record)) => {
                    entries.tensors.insert(name, record);
                }
                Ok(None) => entries.others.push(name),
                Err(problem) => entries.others.push(format!("{name} ({problem})")),
            }
        }
    }
    entries.others.sort_unstable();
    if unnamed > 0 {
        let text = format!("{unnamed} without a name in text of at most {LONGEST_NAME} bytes");
        entries.others.push(text);
    }
    if entries.tensors.is_empty() {
        return Err(format!(
            "it holds no tensors by name, but these entries: {}; save the state_dict() of a model",
            listed(&entries.others)
        ));
    }
    Ok(entries)
}

/// Copies the elements of a tensor in the order of rows. All are known to lie inside.
fn gather(bytes: &[u8], record: &TensorRecord, size: usize, out: &mut Vec<u8>) {
    if record.shape.contains(&0) {
        return;
    }
    // The last dimensions often lie in one piece: `run` elements from dimension `inner` on.
    let (mut inner, mut run) = (record.shape.len(), 1);
    while inner > 0 && (record.strides[inner - 1] == run || record.shape[inner - 1] == 1) {
        inner -= 1;
        run *= record.shape[inner];
    }
    let mut index = vec![0; inner];
    loop {
        let steps = index.iter().zip(&record.strides);
        let at = steps.map(|(i, stride)| i * stride).sum::<usize>() + record.offset;
        out.extend_from_slice(&bytes[at * size..(at + run) * size]);
        // The next index, last dimension first.
        let Some(d) = (0..inner).rev().find(|&d| index[d] + 1 < record.shape[d]) else {
            return;
        };
        index[d] += 1;
        index[d + 1..].fill(0);
    }
}

/// Entries of a dictionary that have a name in text, and the number of those that have none.
fn dict(pickle: &Pickle, id: Id) -> Option<(Vec<(&str, Id)>, usize)> {
    let Node::Dict(items) = pickle.get(id) else {
        return None;
    };
    // As in Python, the last one of a name counts.
    let mut named: Vec<(&str, Id)> = Vec::with_capacity(items.len());
    let mut places: HashMap<&str, usize> = HashMap::new();
    let mut unnamed = 0;
    for &(key, value) in items {
        let name = match pickle.get(key) {
            Node::Text(name) if name.len() <= LONGEST_NAME => name.as_str(),
            _ => {
                unnamed += 1;
                continue;
            }
        };
        let place = *places.entry(name).or_insert(named.len());
        match named.get_mut(place) {
            Some(entry) => entry.1 = value,
            None => named.push((name, value)),
        }
    }
    Some((named, unnamed))
}

/// The tensor that [`REBUILD_TENSOR`] is asked to make; `None` if this is something else.
fn record(pickle: &Pickle, id: Id) -> Result<Option<TensorRecord>, String> {
    match call(pickle, id) {
        // A parameter wraps a tensor, which does not wrap another.
        Some(("torch._utils _rebuild_parameter", [tensor, ..])) => match call(pickle, *tensor) {
            Some((REBUILD_TENSOR, _)) => record(pickle, *tensor),
            _ => Ok(None),
        },
        Some((REBUILD_TENSOR, [storage, offset, shape, strides, rest @ ..])) => {
            // After two arguments of its gradient.
            if let Some(&pending) = rest.get(2) {
                refuse_pending(pickle, pending)?;
            }
            let (dtype, storage) = self::storage(pickle, *storage)?;
            let record = TensorRecord {
                shape: sizes(pickle, *shape)?,
                strides: sizes(pickle, *strides)?,
                offset: size(pickle, *offset)?,
                dtype,
                storage,
            };
            let (sizes, strides) = (record.shape.len(), record.strides.len());
            if sizes != strides {
                return Err(format!("{sizes} sizes with {strides} strides"));
            }
            Ok(Some(record))
        }
        _ => Ok(None),
    }
}

/// Refuses a view that PyTorch computes when it is read: it marks one as negated or conjugated, and stores the values before.
fn refuse_pending(pickle: &Pickle, marks: Id) -> Result<(), String> {
    if let Node::Dict(marks) = pickle.get(marks)
        && let Some(&(mark, _)) = marks.first()
    {
        let mark = match pickle.get(mark) {
            Node::Text(mark) => shortened(mark),
            _ => "something without a name".to_owned(),
        };
        return Err(format!(
            "a view that is marked as {mark}; save tensor.resolve_neg().resolve_conj() instead"
        ));
    }
    Ok(())
}

/// Function and arguments of a call; `None` if this is something else.
fn call(pickle: &Pickle, id: Id) -> Option<(&str, &[Id])> {
    if let Node::Call(function, arguments) = pickle.get(id)
        && let Node::Global(function) = pickle.get(*function)
        && let Node::Tuple(arguments) = pickle.get(*arguments)
    {
        return Some((function, arguments));
    }
    None
}

/// Type and entry of a storage: the persistent id ("storage", type, key, device, elements).
fn storage(pickle: &Pickle, id: Id) -> Result<(DType, String), String> {
    if let Node::Persistent(id) = pickle.get(id)
        && let Node::Tuple(parts) = pickle.get(*id)
        && let [_, kind, key, ..] = parts.as_slice()
        && let (Node::Global(kind), Node::Text(key)) = (pickle.get(*kind), pickle.get(*key))
    {
        let dtype = match kind.as_str() {
            "torch FloatStorage" => DType::F32,
            "torch DoubleStorage" => DType::F64,
            "torch HalfStorage" => DType::F16,
            "torch BFloat16Storage" => DType::BF16,
            "torch LongStorage" => DType::I64,
            "torch ByteStorage" => DType::U8,
            other => {
                let other = shortened(other);
                return Err(format!("values of the type \"{other}\" are not supported"));
            }
        };
        if key.len() > LONGEST_KEY {
            let length = key.len();
            return Err(format!(
                "the name of its storage has {length} bytes, more than {LONGEST_KEY}"
            ));
        }
        return Ok((dtype, key.clone()));
    }
    Err("a tensor without a storage".to_owned())
}

fn sizes(pickle: &Pickle, id: Id) -> Result<Vec<usize>, String> {
    match pickle.get(id) {
        Node::Tuple(items) if items.len() > MOST_DIMENSIONS => Err(format!(
            "{} dimensions, more than {MOST_DIMENSIONS}",
            items.len()
        )),
        Node::Tuple(items) => items.iter().map(|&item| size(pickle, item)).collect(),
        _ => Err("sizes that are no tuple".to_owned()),
    }
}

fn size(pickle: &Pickle, id: Id) -> Result<usize, String> {
    match pickle.get(id) {
        Node::Int(n) => usize::try_from(*n).map_err(|_| format!("a size of {n}")),
        _ => Err("a size that is no number".to_owned()),
    }
}

/// The beginning of a text that many entries may share.
fn shortened(text: &str) -> String {
    text.chars().take(LONGEST_KEY).collect()
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::*;

    const FILES: [&[u8]; 3] = [
        include_bytes!("../../../../tests/golden/weights/plain.pt"),
        include_bytes!("../../../../tests/golden/weights/checkpoint.pt"),
        include_bytes!("../../../../tests/golden/weights/layouts.pt"),
    ];

    /// An archive's checksums refuse nearly every damage to a pickle: here it comes without.
    #[test]
    fn damaged_descriptions_are_refused_or_read_without_panic() {
        let mut generator = ChaCha8Rng::seed_from_u64(3);
        let mut read = 0;
        for file in FILES {
            let archive = Archive::new(file.to_vec()).unwrap();
            let pickle = archive.read("data.pkl").unwrap();
            describe(&pickle).unwrap();
            for _ in 0..3000 {
                let mut damaged = pickle.clone();
                for _ in 0..=generator.next_u32() % 4 {
                    let at = generator.next_u64() as usize % damaged.len();
                    damaged[at] = match generator.next_u32() % 3 {
                        0 => generator.next_u32() as u8,
                        1 => damaged[at] ^ 1 << (generator.next_u32() % 8),
                        _ => pickle[generator.next_u64() as usize % pickle.len()],
                    };
                }
                if generator.next_u32().is_multiple_of(8) {
                    damaged.truncate(generator.next_u64() as usize % damaged.len());
                }
                for record in describe(&damaged).unwrap_or_default().tensors.values() {
                    // Sizes and strides may be anything now.
                    read += usize::from(archive.tensor(record).is_ok());
                }
            }
        }
        assert!(
            read > 1000,
            "most damages were refused at once: {read} tensors read"
        );
    }

    #[test]
    fn a_pair_of_a_pair_of_a_pair_takes_no_memory() {
        // 2^10000 leaves, if they were copied.
        let mut bytes = b"\x80\x02N".to_vec();
        for _ in 0..10_000 {
            bytes.extend(b"q\x00h\x00h\x00\x86");
        }
        bytes.push(b'.');
        let refusal = describe(&bytes).unwrap_err();
        assert!(refusal.starts_with("it holds no dictionary"), "{refusal}");
    }

    const STORAGE: &[u8] =
        b"(X\x07\0\0\0storagectorch\nFloatStorage\nX\x01\0\0\x000X\x03\0\0\0cpuK\x06tQ";

    /// A dictionary whose entry `first` is a tensor of so many sizes, which are the strides as well; number 1 of the memo is the tensor.
    fn of_sizes(count: usize) -> Vec<u8> {
        let mut bytes = b"\x80\x02}X\x05\0\0\0firstctorch._utils\n_rebuild_tensor_v2\n(".to_vec();
        bytes.extend([STORAGE, b"K\0("].concat());
        bytes.extend(b"K\x01".repeat(count));
        bytes.extend(b"tq\x00h\x00tRq\x01s");
        bytes
    }

    /// A text of so many letters.
    fn text(letters: u32) -> Vec<u8> {
        let mut bytes = b"X".to_vec();
        bytes.extend(letters.to_le_bytes());
        bytes.extend(b"k".repeat(letters as usize));
        bytes
    }

    #[test]
    fn entries_that_share_a_long_text_or_description_take_no_memory() {
        let mut sizes = of_sizes(1 << 20);
        for entry in 0..10_000 {
            sizes.extend(format!("X\x05\0\0\0{entry:05}h\x01s").as_bytes());
        }
        let mut classes = [b"\x80\x02}", &text(1 << 20)[..], b"q\x00"].concat();
        classes.extend(b"h\x00h\x00\x93s".repeat(10_000));
        // Names and sizes that are long, but not too long.
        let mut names = [&of_sizes(16), &text(240)[..], b"q\x02h\x01s"].concat();
        let mut keys = [b"\x80\x02}", &text(1 << 20)[..], b"q\x02Ns"].concat();
        for entry in 0..100_000 {
            let inner = format!("X\x05\0\0\0{entry:05}}}h\x02");
            names.extend([inner.as_bytes(), b"h\x01ss"].concat());
            keys.extend([inner.as_bytes(), b"Nss"].concat());
        }
        for (mut bytes, told) in [
            (sizes, "(1048576 dimensions, more than 16)"),
            (classes, "a class with a name of 2097152 bytes"),
            (names, "describes more than it can hold"),
            (keys, "100001 without a name"),
        ] {
            bytes.push(b'.');
            let refusal = describe(&bytes).unwrap_err();
            assert!(refusal.contains(told), "{refusal}");
        }
    }

    #[test]
    fn a_view_that_is_marked_as_negated_is_refused() {
        let file = |marks: &[u8]| {
            let beginning = b"\x80\x02}X\x01\0\0\0wctorch._utils\n_rebuild_tensor_v2\n(";
            let sizes = b"K\0K\x06\x85K\x01\x85\x89}";
            [beginning, STORAGE, sizes, marks, b"tRs."].concat()
        };
        for marks in [&b""[..], b"}", b"N"] {
            let entries = describe(&file(marks)).unwrap();
            assert_eq!(entries.tensors["w"].shape, [6], "{marks:?}");
        }
        let refusal = describe(&file(b"}X\x03\0\0\0neg\x88s")).unwrap_err();
        assert!(
            refusal.contains("w (a view that is marked as neg;"),
            "{refusal}"
        );
    }

    #[test]
    fn a_dictionary_in_itself_is_looked_through_once() {
        // d = {}; d["a"] = d
        let refusal = describe(b"\x80\x02}q\x00X\x01\0\0\0ah\x00s.").unwrap_err();
        assert!(refusal.starts_with("it holds no tensors"), "{refusal}");
    }

    #[test]
    fn stated_sizes_beyond_the_storage_are_refused() {
        let archive = Archive::new(FILES[0].to_vec()).unwrap();
        let record = |shape: &[usize], strides: &[usize], offset| TensorRecord {
            shape: shape.to_vec(),
            strides: strides.to_vec(),
            offset,
            dtype: DType::F32,
            storage: "0".to_owned(),
        };
        assert!(archive.tensor(&record(&[2, 3], &[3, 1], 0)).is_ok());
        // Six elements are stored.
        for bad in [
            record(&[7], &[1], 0),
            record(&[2], &[1], 5),
            record(&[2], &[usize::MAX], 1),
            record(&[1 << 40], &[0], 0),
            record(&[usize::MAX, usize::MAX], &[0, 0], 0),
            record(&[1], &[1], usize::MAX),
        ] {
            assert!(archive.tensor(&bad).is_err(), "{bad:?}");
        }
    }
}
