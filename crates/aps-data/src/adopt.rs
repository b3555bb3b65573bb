//! Taking over finished maps from another folder, to join what shards wrote apart.

use std::fs::{self, File};
use std::path::Path;

use crate::durable::{self, PartialFolder};
use crate::error::{Error, at};
use crate::json;
use crate::manifest::{MAP_FILE, MapEntry, MapManifest};
use crate::writer::DatasetWriter;

impl DatasetWriter {
    /// Copies one whole map out of another folder.
    ///
    /// The folder needs no manifest. Each file is checked against its checksum on the way.
    ///
    /// # Errors
    /// [`Error::ConfigMismatch`] when the map was made with other settings, [`Error::Checksum`]
    /// when a file is damaged, [`Error::Input`] when it is there already or belongs to another
    /// shard, [`Error::Io`]. Nothing of the map is then in this data set.
    pub fn adopt_map(&self, other: impl AsRef<Path>, id: u32) -> Result<(), Error> {
        self.must_want(id)?;
        let source = other.as_ref().join(MapEntry::folder_of(id));
        let manifest = MapManifest::read_of(id, &source)?;
        let version = manifest.format_version;
        self.config()
            .must_have_made(&manifest.config(), version, &source.join(MAP_FILE))?;
        let folder = PartialFolder::create(&self.folder().root, &MapEntry::folder_of(id))?;
        for file in &manifest.map.files {
            let (from, to) = (source.join(&file.name), folder.path().join(&file.name));
            fs::copy(&from, &to).map_err(at(&from, "copy"))?;
            let (_, found) = durable::size_and_sha256(&to)?;
            if found != file.sha256 {
                return Err(Error::Checksum {
                    path: from,
                    stored: file.sha256.clone(),
                    found,
                });
            }
            File::open(&to)
                .and_then(|file| file.sync_all())
                .map_err(at(&to, "write"))?;
        }
        durable::write_synced(&folder.path().join(MAP_FILE), &json::to_bytes(&manifest))?;
        folder.complete()?;
        self.folder().register(manifest.map);
        Ok(())
    }
}
