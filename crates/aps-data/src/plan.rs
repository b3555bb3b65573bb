//! `plan.json`: the plan of an unfinished data set.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::durable;
use crate::error::Error;
use crate::json;
use crate::manifest::{FORMAT, FORMAT_VERSION, parse, sound};

/// File name of the plan of an unfinished data set.
pub(crate) const PLAN_FILE: &str = "plan.json";

/// Plan of a run: kept beside the maps until the manifest is written.
///
/// It decides nothing about the data: settings are in each map, and a run that continues is given its
/// maps anew. It shows the maps that are missing, and the command that makes them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Plan {
    /// The maps of the data set when finished, of all shards; ascending.
    pub maps: Vec<u32>,
    /// Number of shards that make the maps, if they are shared.
    pub shards: Option<u32>,
    /// Command that makes the maps, without shard and output folder: one word each.
    pub command: Vec<String>,
}

/// Content of the file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanFile {
    format: String,
    format_version: u64,
    maps: Vec<u32>,
    shards: Option<u32>,
    command: Vec<String>,
}

impl Plan {
    /// Reads the plan in a folder, if there is one.
    pub(crate) fn read(root: &Path) -> Result<Option<Self>, Error> {
        let path = root.join(PLAN_FILE);
        match path.is_file() {
            true => Self::parse(&path, &json::read_bytes(&path)?).map(Some),
            false => Ok(None),
        }
    }

    pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Self, Error> {
        let file: PlanFile = parse(path, bytes)?;
        let plan = Plan {
            maps: file.maps,
            shards: file.shards,
            command: file.command,
        };
        sound(path, plan, Self::problem)
    }

    fn problem(&self) -> Option<String> {
        if !self.maps.is_sorted_by(|a, b| a < b) {
            Some("maps are not in ascending order".into())
        } else {
            (self.shards == Some(0)).then(|| "no data set is made of 0 shards".into())
        }
    }

    pub(crate) fn write(&self, root: &Path) -> Result<(), Error> {
        let file = PlanFile {
            format: FORMAT.into(),
            format_version: FORMAT_VERSION,
            maps: self.maps.clone(),
            shards: self.shards,
            command: self.command.clone(),
        };
        durable::replace_file(&root.join(PLAN_FILE), &json::to_bytes(&file))
    }
}
