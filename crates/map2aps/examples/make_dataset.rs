//! Makes a small data set of synthetic cities in the folder `data/example`.

use std::path::Path;

use map2aps::{Control, DatasetPlan, MapSource};

/// Runs the example.
pub fn main() -> map2aps::Result<()> {
    let plan = DatasetPlan {
        maps: MapSource::Synthetic { count: 7 },
        tx_per_map: 2,
        rx_per_map: 20,
        ..DatasetPlan::default()
    };
    let out = Path::new("data/example");
    let made = plan.make(out, &plan.maps.ids()?, &Control::default())?;
    println!("{} links, {} paths", made.tally.links, made.tally.paths);
    Ok(())
}
