//! Writing: for tests, and for whoever wants our paths in tools that read this format.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use half::f16;

use super::{
    Chain, Entries, MAGIC, MAX_BYTES, Path, Propbin, PropbinError, ROOFTOP, Receiver, Stored,
    Version,
};

impl Propbin {
    /// Adds a receiver, to which the paths added next belong; place in metres, power in dBm, loss in dB.
    pub fn add_receiver(
        &mut self,
        id: i32,
        position_m: [f32; 3],
        total_power_dbm: Option<f32>,
        total_loss_db: Option<f32>,
    ) {
        let end = self.paths.len();
        self.receivers.push(Receiver {
            id,
            position_m,
            total_power_dbm,
            total_loss_db,
            paths: end..end,
        });
    }

    /// Adds a path to the last receiver. Version 2 rounds its numbers to half precision when it is written.
    ///
    /// # Errors
    /// [`PropbinError::Entry`] without a receiver, when receiver or path have more than 65,535 paths or chain entries, or
    /// when the chain is not of the version's kind.
    pub fn add_path(&mut self, path: &Path, chain: &Chain<'_>) -> Result<(), PropbinError> {
        let index = self.paths.len();
        let refuse = |problem| {
            Err(PropbinError::Entry {
                what: "path",
                index,
                problem,
            })
        };
        let Some(receiver) = self.receivers.last_mut() else {
            return refuse("it has no receiver");
        };
        if receiver.paths.len() >= usize::from(u16::MAX) {
            return refuse("its receiver is full");
        }
        let length = match chain {
            Chain::Points(points) => points.len(),
            Chain::Vertices(vertices) => vertices.len(),
            Chain::Rooftop(points) => 2 * points.len(),
        };
        if length > usize::from(u16::MAX) {
            return refuse("its chain is too long");
        }
        let (first, kind) = match (&mut self.entries, chain) {
            (Entries::Points(all), Chain::Points(points)) => {
                all.extend_from_slice(points);
                (all.len() - length, 0)
            }
            (Entries::Words(all), Chain::Vertices(vertices)) => {
                all.extend_from_slice(vertices);
                (all.len() - length, 0)
            }
            (Entries::Words(all), Chain::Rooftop(points)) => {
                all.extend(
                    points
                        .as_flattened()
                        .iter()
                        .map(|&v| f16::from_f32(v).to_bits()),
                );
                (all.len() - length, ROOFTOP)
            }
            (Entries::Points(_), Chain::Vertices(_) | Chain::Rooftop(_))
            | (Entries::Words(_), Chain::Points(_)) => {
                return refuse("its version has no such chain");
            }
        };
        receiver.paths.end += 1;
        self.paths.push(Stored {
            path: *path,
            kind,
            chain: first..first + length,
        });
        Ok(())
    }

    /// Returns the bytes of the file, not compressed.
    ///
    /// # Errors
    /// [`PropbinError::TooLarge`].
    pub fn to_bytes(&self) -> Result<Vec<u8>, PropbinError> {
        let entries = match &self.entries {
            Entries::Points(points) => points.len(),
            Entries::Words(words) => words.len(),
        };
        let mut out = Vec::new();
        out.extend(MAGIC.to_le_bytes());
        out.extend(self.version.number().to_le_bytes());
        put(&mut out, &self.source_m);
        for count in [self.receivers.len(), self.paths.len(), entries] {
            out.extend((count as u32).to_le_bytes());
        }
        for receiver in &self.receivers {
            out.extend(receiver.id.to_le_bytes());
            put(&mut out, &receiver.position_m);
            let totals = [receiver.total_power_dbm, receiver.total_loss_db];
            put(&mut out, &totals.map(|value| value.unwrap_or(f32::NAN)));
            put_range(&mut out, &receiver.paths);
        }
        for stored in &self.paths {
            match self.version {
                Version::Full => put_full(&mut out, stored),
                Version::Compact => put_compact(&mut out, stored),
            }
        }
        match &self.entries {
            Entries::Points(points) => put(&mut out, points.as_flattened()),
            Entries::Words(words) => out.extend(words.iter().flat_map(|word| word.to_le_bytes())),
        }
        match out.len() as u64 <= MAX_BYTES {
            true => Ok(out),
            false => Err(PropbinError::TooLarge {
                bytes: out.len() as u64,
            }),
        }
    }

    /// Returns the bytes of the file, compressed by gzip; the same each time.
    ///
    /// # Errors
    /// As [`Propbin::to_bytes`].
    pub fn to_gzip(&self) -> Result<Vec<u8>, PropbinError> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(&self.to_bytes()?)?;
        Ok(encoder.finish()?)
    }
}

fn put(out: &mut Vec<u8>, values: &[f32]) {
    out.extend(values.iter().flat_map(|v| v.to_le_bytes()));
}

fn put_range(out: &mut Vec<u8>, range: &std::ops::Range<usize>) {
    out.extend((range.len() as u16).to_le_bytes());
    out.extend([0, 0]);
    out.extend((range.start as u32).to_le_bytes());
}

fn put_full(out: &mut Vec<u8>, stored: &Stored) {
    let path = &stored.path;
    put(out, &[path.loss_db, path.length_m]);
    put(out, &path.angles());
    put(out, &[path.delay_ns]);
    put_range(out, &stored.chain);
}

fn put_compact(out: &mut Vec<u8>, stored: &Stored) {
    let path = &stored.path;
    let lengths = [path.loss_db, path.length_m, path.delay_ns];
    for value in lengths.into_iter().chain(path.angles()) {
        out.extend(f16::from_f32(value).to_le_bytes());
    }
    out.extend((stored.chain.len() as u16).to_le_bytes());
    out.extend([stored.kind.cast_unsigned(), 0, 0, 0]);
    out.extend((stored.chain.start as u32).to_le_bytes());
}
