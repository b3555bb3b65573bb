//! `plan.json`: what an unfinished data set is to become.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::durable;
use crate::error::Error;
use crate::json;
use crate::manifest::{FORMAT, FORMAT_VERSION, parse};

/// File name of the plan of an unfinished data set.
pub(crate) const PLAN_FILE: &str = "plan.json";

/// What a run is to make: kept beside the maps until the manifest is written.
///
/// It decides nothing about the data: settings are in each map, and a run that goes on is told anew
/// what to make. It lets others see what is missing, and how it can be made.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Plan {
    /// The maps of the data set when finished, of all shards; ascending.
    pub maps: Vec<u32>,
    /// How many shards make them, if they are shared.
    pub shards: Option<u32>,
    /// The command that makes them, without shard and output folder: one word each.
    pub command: Vec<String>,
}

/// The file as it is.
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
    /// The plan in a folder, if there is one.
    pub(crate) fn read(root: &Path) -> Result<Option<Self>, Error> {
        let path = root.join(PLAN_FILE);
        match path.is_file() {
            true => Self::parse(&path, &json::read_bytes(&path)?).map(Some),
            false => Ok(None),
        }
    }

    pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Self, Error> {
        let PlanFile {
            maps,
            shards,
            command,
            ..
        } = parse(path, bytes)?;
        let problem = if !maps.is_sorted_by(|a, b| a < b) {
            "maps are not in ascending order"
        } else if shards == Some(0) {
            "no data set is made of 0 shards"
        } else {
            return Ok(Plan {
                maps,
                shards,
                command,
            });
        };
        Err(Error::Damaged {
            path: path.into(),
            problem: problem.into(),
        })
    }

    pub(crate) fn write(&self, root: &Path) -> Result<(), Error> {
        let Plan {
            maps,
            shards,
            command,
        } = self.clone();
        let file = PlanFile {
            format: FORMAT.into(),
            format_version: FORMAT_VERSION,
            maps,
            shards,
            command,
        };
        durable::replace_file(&root.join(PLAN_FILE), &json::to_bytes(&file))
    }
}
