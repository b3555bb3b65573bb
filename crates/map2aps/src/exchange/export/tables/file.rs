//! Parquet files.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, FloatType, Int32Type};
use parquet::errors::Result as ParquetResult;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::parser::parse_message_type;

use super::columns::{Column, Values};
use crate::error::Result;
use crate::exchange::ExchangeError;

/// The bytes of a file of groups of rows, of which there is at least one.
pub fn bytes(name: &str, groups: impl Iterator<Item = Vec<Column>>) -> Result<Vec<u8>> {
    Ok(encode(name, groups).map_err(ExchangeError::Parquet)?)
}

/// The bytes of a file that is there, was written to its end and has so many rows.
pub fn whole(path: &Path, rows: usize) -> Option<Vec<u8>> {
    let file = SerializedFileReader::new(File::open(path).ok()?).ok()?;
    let found = file.metadata().file_metadata().num_rows();
    (found == rows as i64).then(|| std::fs::read(path).ok())?
}

fn encode(name: &str, groups: impl Iterator<Item = Vec<Column>>) -> ParquetResult<Vec<u8>> {
    let mut groups = groups.peekable();
    let empty = Vec::new();
    let schema = schema(name, groups.peek().unwrap_or(&empty));
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_created_by(concat!("map2aps ", env!("CARGO_PKG_VERSION")).into())
        .build();
    let schema = Arc::new(parse_message_type(&schema)?);
    let mut file = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
    for columns in groups {
        let mut group = file.next_row_group()?;
        for column in columns {
            let writer = group.next_column()?;
            let mut writer = writer.expect("the schema has a column for each");
            write(&mut writer, &column.values)?;
            writer.close()?;
        }
        group.close()?;
    }
    file.into_inner()
}

/// The schema in the format's own language.
fn schema(name: &str, columns: &[Column]) -> String {
    let mut text = format!("message {name} {{\n");
    for Column { name, values, .. } in columns {
        let [kind, ..] = values.types();
        text += &match values {
            Values::Texts(_) => format!("required {kind} {name} (UTF8);"),
            Values::FloatLists(..) | Values::DoubleLists(..) => format!(
                "required group {name} (LIST) {{ repeated group list {{ required {kind} element; }} }}"
            ),
            Values::Integers(_) | Values::Floats(_) | Values::Doubles(_) | Values::Bytes(_) => {
                format!("required {kind} {name};")
            }
        };
        text += "\n";
    }
    text + "}"
}

fn write(writer: &mut SerializedColumnWriter<'_>, values: &Values) -> ParquetResult<()> {
    match values {
        Values::Integers(v) => writer.typed::<Int32Type>().write_batch(v, None, None)?,
        Values::Floats(v) => writer.typed::<FloatType>().write_batch(v, None, None)?,
        Values::Doubles(v) => writer.typed::<DoubleType>().write_batch(v, None, None)?,
        Values::Texts(v) => {
            let bytes: Vec<ByteArray> = v.iter().map(|text| text.as_str().into()).collect();
            let writer = writer.typed::<ByteArrayType>();
            writer.write_batch(&bytes, None, None)?
        }
        Values::Bytes(v) => {
            let bytes: Vec<ByteArray> = v.iter().cloned().map(ByteArray::from).collect();
            let writer = writer.typed::<ByteArrayType>();
            writer.write_batch(&bytes, None, None)?
        }
        Values::FloatLists(v, lengths) => {
            let (writer, (defined, repeated)) = (writer.typed::<FloatType>(), levels(lengths));
            writer.write_batch(v, Some(&defined), Some(&repeated))?
        }
        Values::DoubleLists(v, lengths) => {
            let (writer, (defined, repeated)) = (writer.typed::<DoubleType>(), levels(lengths));
            writer.write_batch(v, Some(&defined), Some(&repeated))?
        }
    };
    Ok(())
}

/// Levels of lists: defined 1 for an element and 0 for an empty list, repeated 0 for the first of a list and 1 for the others.
fn levels(lengths: &[usize]) -> (Vec<i16>, Vec<i16>) {
    let (mut defined, mut repeated) = (Vec::new(), Vec::new());
    for &length in lengths {
        defined.push((length > 0).into());
        repeated.push(0);
        defined.extend(std::iter::repeat_n(1, length.saturating_sub(1)));
        repeated.extend(std::iter::repeat_n(1, length.saturating_sub(1)));
    }
    (defined, repeated)
}
