//! The array files of a map while they grow.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use crate::arrays::{ArraySpec, Counts, ProfileNames, arrays_of};
use crate::error::{Error, at, in_array};
use crate::layout::Layout;
use crate::npy::{Element, Writer};
use crate::paths::{InteractionKind, PathTable};
use crate::profile::{Profile, Samples};

/// An array file under construction.
#[derive(Debug)]
struct ArrayFile {
    name: &'static str,
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
}

/// The array files of a map, one for each array of its layout.
#[derive(Debug)]
pub(crate) struct ArrayFiles {
    files: Vec<ArrayFile>,
    /// Paths and interactions so far.
    paths: u64,
    interactions: u64,
}

impl ArrayFiles {
    /// Creates the files of a layout in a folder.
    pub fn create(folder: &Path, layout: &Layout) -> Result<Self, Error> {
        let specs = arrays_of(layout, &Counts::default()).expect("no rows overflow nothing");
        let create = |spec: &ArraySpec| {
            let path = folder.join(format!("{}.npy", spec.name));
            let file = File::create_new(&path).map_err(at(&path, "create"))?;
            let writer = Writer::new(BufWriter::new(file), spec.dtype, &spec.shape[1..]);
            Ok(ArrayFile {
                name: spec.name,
                writer: writer.map_err(in_array(&path, "write"))?,
                path,
            })
        };
        let mut files = ArrayFiles {
            files: specs.iter().map(create).collect::<Result<_, _>>()?,
            paths: 0,
            interactions: 0,
        };
        if layout.paths {
            files.push("path_offset", &[0_u64])?;
            files.push("interaction_offset", &[0_u64])?;
        }
        Ok(files)
    }

    /// Appends elements to an array of the layout.
    pub fn push<T: Element>(&mut self, name: &str, data: &[T]) -> Result<(), Error> {
        let file = self.files.iter_mut().find(|file| file.name == name);
        let file = file.expect("the layout has the array");
        let pushed = file.writer.push(data);
        pushed.map_err(in_array(&file.path, "write"))
    }

    /// Appends links, as indices of transmitter and receiver.
    pub fn push_links(&mut self, links: &[[u32; 2]]) -> Result<(), Error> {
        let (tx, rx): (Vec<u32>, Vec<u32>) = links.iter().map(|&[t, r]| (t, r)).unzip();
        self.push("link_tx", &tx)?;
        self.push("link_rx", &rx)
    }

    /// Appends the rows of a profile.
    pub fn push_profile(&mut self, names: ProfileNames, rows: &Profile) -> Result<(), Error> {
        match &rows.db {
            Samples::F16(values) => self.push(names.db, values)?,
            Samples::F32(values) => self.push(names.db, values)?,
        }
        self.push(names.max_db, &rows.max_db)?;
        match &rows.argmax {
            Some(places) => self.push(names.argmax, places),
            None => Ok(()),
        }
    }

    /// Appends the paths of links.
    pub fn push_paths(&mut self, table: &PathTable) -> Result<(), Error> {
        let after = |first: u64, offset: &[u64]| -> Vec<u64> {
            offset[1..].iter().map(|end| first + end).collect()
        };
        let kinds = table.interaction_kind.iter();
        let kinds: Vec<u8> = kinds.copied().map(InteractionKind::code).collect();
        self.push("path_offset", &after(self.paths, &table.path_offset))?;
        self.push("path_delay_s", &table.delay_s)?;
        self.push("path_departure_azimuth_rad", &table.departure_azimuth_rad)?;
        self.push("path_arrival_azimuth_rad", &table.arrival_azimuth_rad)?;
        self.push("path_gain", &table.gain)?;
        let ends = after(self.interactions, &table.interaction_offset);
        self.push("interaction_offset", &ends)?;
        self.push("interaction_kind", &kinds)?;
        self.push("interaction_id", &table.interaction_id)?;
        self.push(
            "interaction_point",
            table.interaction_point_m.as_flattened(),
        )?;
        self.paths += table.delay_s.len() as u64;
        self.interactions += kinds.len() as u64;
        Ok(())
    }

    /// Completes the files, which are on disk then, and returns the lengths that decide their shapes.
    pub fn finish(self) -> Result<Counts, Error> {
        let mut counts = Counts::default();
        for ArrayFile { name, path, writer } in self.files {
            let (sink, rows) = writer.finish().map_err(in_array(&path, "write"))?;
            sink.get_ref().sync_all().map_err(at(&path, "write"))?;
            match name {
                "tx" => counts.tx = rows,
                "rx" => counts.rx = rows,
                "status" => counts.links = rows,
                "path_delay_s" => counts.paths = rows,
                "interaction_kind" => counts.interactions = rows,
                _ => {}
            }
        }
        Ok(counts)
    }
}
