//! The array files of a map while they grow.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use half::f16;

use crate::arrays::ProfileNames;
use crate::error::{Error, at, in_array};
use crate::layout::{Precision, ProfileLayout};
use crate::npy::{Element, Writer};
use crate::paths::{InteractionKind, PathTable};
use crate::profile::{Profile, Samples};

/// An array file under construction.
#[derive(Debug)]
pub(crate) struct ArrayFile<T> {
    path: PathBuf,
    writer: Writer<T, BufWriter<File>>,
}

impl<T: Element> ArrayFile<T> {
    pub fn create(folder: &Path, name: &str, row_shape: &[usize]) -> Result<Self, Error> {
        let path = folder.join(format!("{name}.npy"));
        let file = File::create_new(&path).map_err(at(&path, "create"))?;
        let writer =
            Writer::new(BufWriter::new(file), row_shape).map_err(in_array(&path, "write"))?;
        Ok(ArrayFile { path, writer })
    }

    pub fn write(folder: &Path, name: &str, row_shape: &[usize], data: &[T]) -> Result<(), Error> {
        let mut file = Self::create(folder, name, row_shape)?;
        file.push(data)?;
        file.finish().map(|_| ())
    }

    pub fn push(&mut self, data: &[T]) -> Result<(), Error> {
        self.writer
            .push(data)
            .map_err(in_array(&self.path, "write"))
    }

    /// Returns the number of rows; the file is on disk.
    pub fn finish(self) -> Result<usize, Error> {
        let (sink, rows) = self
            .writer
            .finish()
            .map_err(in_array(&self.path, "write"))?;
        sink.get_ref().sync_all().map_err(at(&self.path, "write"))?;
        Ok(rows)
    }
}

#[derive(Debug)]
pub(crate) struct ProfileArrays {
    db: SampleFile,
    max_db: ArrayFile<f32>,
    argmax: Option<ArrayFile<f16>>,
}

#[derive(Debug)]
enum SampleFile {
    F16(ArrayFile<f16>),
    F32(ArrayFile<f32>),
}

impl ProfileArrays {
    pub fn create(
        folder: &Path,
        names: ProfileNames,
        layout: &ProfileLayout,
    ) -> Result<Self, Error> {
        let row = [layout.axis.count];
        let db = match layout.dtype {
            Precision::F16 => SampleFile::F16(ArrayFile::create(folder, names.db, &row)?),
            Precision::F32 => SampleFile::F32(ArrayFile::create(folder, names.db, &row)?),
        };
        let argmax = layout
            .argmax
            .then(|| ArrayFile::create(folder, names.argmax, &row))
            .transpose()?;
        Ok(ProfileArrays {
            db,
            max_db: ArrayFile::create(folder, names.max_db, &[])?,
            argmax,
        })
    }

    pub fn push(&mut self, rows: &Profile) -> Result<(), Error> {
        match (&mut self.db, &rows.db) {
            (SampleFile::F16(file), Samples::F16(values)) => file.push(values)?,
            (SampleFile::F32(file), Samples::F32(values)) => file.push(values)?,
            _ => unreachable!("rows are encoded by the layout that made the file"),
        }
        self.max_db.push(&rows.max_db)?;
        match (&mut self.argmax, &rows.argmax) {
            (Some(file), Some(values)) => file.push(values),
            _ => Ok(()),
        }
    }

    pub fn finish(self) -> Result<(), Error> {
        match self.db {
            SampleFile::F16(file) => file.finish()?,
            SampleFile::F32(file) => file.finish()?,
        };
        self.max_db.finish()?;
        self.argmax.map(ArrayFile::finish).transpose()?;
        Ok(())
    }
}

#[derive(Debug)]
pub(crate) struct PathArrays {
    offset: OffsetFile,
    delay_s: ArrayFile<f64>,
    departure_azimuth_rad: ArrayFile<f64>,
    arrival_azimuth_rad: ArrayFile<f64>,
    gain: ArrayFile<[f64; 2]>,
    interaction_offset: OffsetFile,
    interaction_kind: ArrayFile<u8>,
    interaction_id: ArrayFile<u32>,
    interaction_point: ArrayFile<f64>,
}

impl PathArrays {
    pub fn create(folder: &Path) -> Result<Self, Error> {
        Ok(PathArrays {
            offset: OffsetFile::create(folder, "path_offset")?,
            delay_s: ArrayFile::create(folder, "path_delay_s", &[])?,
            departure_azimuth_rad: ArrayFile::create(folder, "path_departure_azimuth_rad", &[])?,
            arrival_azimuth_rad: ArrayFile::create(folder, "path_arrival_azimuth_rad", &[])?,
            gain: ArrayFile::create(folder, "path_gain", &[])?,
            interaction_offset: OffsetFile::create(folder, "interaction_offset")?,
            interaction_kind: ArrayFile::create(folder, "interaction_kind", &[])?,
            interaction_id: ArrayFile::create(folder, "interaction_id", &[])?,
            interaction_point: ArrayFile::create(folder, "interaction_point", &[2])?,
        })
    }

    pub fn push(&mut self, table: &PathTable) -> Result<(), Error> {
        let kinds = table.interaction_kind.iter();
        let kinds: Vec<u8> = kinds.copied().map(InteractionKind::code).collect();
        self.offset.push(&table.path_offset)?;
        self.delay_s.push(&table.delay_s)?;
        self.departure_azimuth_rad
            .push(&table.departure_azimuth_rad)?;
        self.arrival_azimuth_rad.push(&table.arrival_azimuth_rad)?;
        self.gain.push(&table.gain)?;
        self.interaction_offset.push(&table.interaction_offset)?;
        self.interaction_kind.push(&kinds)?;
        self.interaction_id.push(&table.interaction_id)?;
        self.interaction_point
            .push(table.interaction_point_m.as_flattened())
    }

    /// Returns the number of paths and of interactions.
    pub fn finish(self) -> Result<(usize, usize), Error> {
        self.offset.file.finish()?;
        let paths = self.delay_s.finish()?;
        self.departure_azimuth_rad.finish()?;
        self.arrival_azimuth_rad.finish()?;
        self.gain.finish()?;
        self.interaction_offset.file.finish()?;
        let interactions = self.interaction_kind.finish()?;
        self.interaction_id.finish()?;
        self.interaction_point.finish()?;
        Ok((paths, interactions))
    }
}

/// Running sums: 0, then one entry a row.
#[derive(Debug)]
struct OffsetFile {
    file: ArrayFile<u64>,
    sum: u64,
}

impl OffsetFile {
    fn create(folder: &Path, name: &str) -> Result<Self, Error> {
        let mut file = ArrayFile::create(folder, name, &[])?;
        file.push(&[0])?;
        Ok(OffsetFile { file, sum: 0 })
    }

    /// Appends offsets that start at 0 anew.
    fn push(&mut self, offsets: &[u64]) -> Result<(), Error> {
        let sums: Vec<u64> = offsets[1..].iter().map(|end| self.sum + end).collect();
        self.sum = sums.last().copied().unwrap_or(self.sum);
        self.file.push(&sums)
    }
}
