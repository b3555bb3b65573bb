//! `explain` and `gallery`: what the pages say is what the crates compute, and every picture is well formed.

use std::fs;

use aps_data::Dataset;
use aps_label::{LabelConfig, Labeler, PathSample};
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Scene, TraceConfig, Tracer};

use crate::folder::Folder;
use crate::{assert_told, fail, succeed};

const SETTINGS: &str = "--profile smoke --store";

/// Number of pictures in a page, each parsed.
#[track_caller]
fn pictures_in(page: &str) -> usize {
    let mut found = 0;
    let mut rest = page;
    while let Some(start) = rest.find("<svg") {
        let end = start + rest[start..].find("</svg>").expect("it is closed") + "</svg>".len();
        roxmltree::Document::parse(&rest[start..end]).expect("it is well formed");
        found += 1;
        rest = &rest[end..];
    }
    found
}

/// The text of each cell of each row of so many cells that is linked to a path.
fn linked_rows(page: &str, cells: usize) -> Vec<Vec<String>> {
    let text = |cell: &str| {
        let cell = cell.split("</td>").next().unwrap();
        let words = cell.split('<').filter_map(|part| part.split_once('>'));
        words.map(|(_, text)| text).collect::<String>()
    };
    let rows = page.split("<tr data-path=").skip(1).map(|row| {
        let row = row.split("</tr>").next().unwrap();
        let cells = row.split("<td").skip(1);
        cells.map(|cell| text(&format!("<td{cell}"))).collect()
    });
    rows.filter(|row: &Vec<String>| row.len() == cells)
        .collect()
}

fn number(cell: &str) -> f64 {
    let text = cell.replace('\u{2212}', "-");
    text.split_whitespace().next().unwrap().parse().unwrap()
}

#[test]
fn table_of_paths_holds_what_the_tracer_found() {
    let folder = Folder::new();
    let (map, page) = (folder.arg("house.json"), folder.arg("link.html"));
    let house = "[[[100,100],[120,100],[120,110],[100,110],[100,100]]]";
    fs::write(&map, house).unwrap();
    succeed(&format!(
        "explain --map {map} --tx 90,130 --rx 120,120 --limits r2d1 --out {page}"
    ));
    let page = fs::read_to_string(page).unwrap();
    assert_eq!(pictures_in(&page), 2);

    let scene = Scene::from_radiomapseer(house).unwrap();
    let tracer = Tracer::new(&scene, TraceConfig::default()).unwrap();
    let (tx, rx) = (DVec2::new(90.0, 130.0), DVec2::new(120.0, 120.0));
    let mut paths = tracer.trace(tx, rx).unwrap().paths;
    paths.sort_by(|p, q| q.gain_db().total_cmp(&p.gain_db()));
    let rows = linked_rows(&page, 9);
    assert_eq!(rows.len(), paths.len());
    for (i, (row, path)) in rows.iter().zip(&paths).enumerate() {
        assert_eq!(number(&row[0]) as usize, i + 1);
        assert_eq!(row[1] == "LoS", path.is_line_of_sight());
        for (cell, value) in [
            (2, path.length_m),
            (3, path.delay_s * 1e9),
            (4, path.arrival_azimuth_rad.to_degrees()),
            (5, path.gain_db()),
        ] {
            assert!(
                (number(&row[cell]) - value).abs() < 0.051,
                "{row:?}: {value}"
            );
        }
    }

    // The highest lobe is as high as the label, and its table names the label's angle.
    let samples: Vec<PathSample> = paths
        .iter()
        .map(|p| PathSample {
            delay_s: p.delay_s,
            arrival_azimuth_rad: p.arrival_azimuth_rad,
            gain_db: p.gain_db(),
        })
        .collect();
    let labeler = Labeler::new(&LabelConfig::paper()).unwrap();
    let label = labeler.label(&samples).unwrap().unwrap();
    let top_db = label.aps_db.iter().copied().fold(f64::MIN, f64::max);
    let bin = label.aps_db.iter().position(|db| *db == top_db).unwrap();
    let lobes = linked_rows(&page, 6);
    let is_top = |row: &&Vec<String>| (number(&row[2]) - top_db).abs() < 0.051;
    let at = |row: &Vec<String>| number(&row[1]);
    assert!(
        lobes.iter().any(|row| at(row) == labeler.angles_deg()[bin]),
        "{lobes:?}"
    );
    // Its mirror lobe is where the formula puts it.
    let top = lobes.iter().find(is_top);
    let top = top.expect("the highest lobe is in the table");
    let apart = (180.0 - at(top) - number(&top[5])).rem_euclid(360.0);
    assert!(apart.min(360.0 - apart) <= 4.0, "{top:?}");
}

#[test]
fn heading_turns_the_angles_and_nothing_else() {
    let folder = Folder::new();
    let page = |heading: &str| {
        let out = folder.arg("link.html");
        let line =
            format!("explain --map synthetic --tx 63,175 --rx 151,57 --limits r2d1 --out {out}");
        let told = succeed(&format!("{line} {heading}"));
        assert_eq!(
            told.contains("from the array's heading 90 deg"),
            heading == "--heading 90"
        );
        fs::read_to_string(out).unwrap()
    };
    let (own, turned) = (page(""), page("--heading 90"));
    assert!(page("--heading=0") == own);
    let (own, turned) = (linked_rows(&own, 9), linked_rows(&turned, 9));
    assert!(!own.is_empty() && own.len() == turned.len());
    for (own, turned) in own.iter().zip(&turned) {
        let differ: Vec<usize> = (0..9).filter(|&i| own[i] != turned[i]).collect();
        assert!(!differ.is_empty(), "{own:?}");
        for i in differ {
            let apart = (number(&own[i]) - number(&turned[i]) - 90.0).rem_euclid(360.0);
            assert!(apart.min(360.0 - apart) < 0.11, "{i}: {own:?} {turned:?}");
        }
    }
    for heading in ["400", "nan", "north"] {
        let out = folder.arg("no.html");
        let line = format!("explain --map synthetic --tx 63,175 --rx 151,57 --out {out}");
        assert!(fail(&format!("{line} --heading {heading}")).contains("no heading in degrees"));
    }
}

#[test]
fn stored_and_retraced_paths_make_the_same_page() {
    let folder = Folder::new();
    folder.make("stored", &[SETTINGS, "aps,paths"]);
    folder.make("bare", &[SETTINGS, "aps"]);
    let page = |data: &str| {
        let (data, out) = (folder.arg(data), folder.arg(&format!("{data}.svg")));
        succeed(&format!("explain {data} --link 1,2,5 --out {out}"));
        fs::read_to_string(out).unwrap()
    };
    // The synthetic city is known from the manifest.
    let again = page("bare");
    assert!(page("stored") == again);
    let document = roxmltree::Document::parse(&again).unwrap();
    assert!(document.descendants().any(|n| n.has_attribute("data-path")));
    assert!(
        !again.contains("var("),
        "a file of its own knows no variables"
    );
}

#[test]
fn gallery_shows_links_and_counts_all() {
    let folder = Folder::new();
    folder.make("data", &[SETTINGS, "aps,pdp,paths"]);
    let show = |more: &str| {
        let (data, out) = (folder.arg("data"), folder.arg("gallery.html"));
        succeed(&format!("gallery {data} --out {out} {more}"));
        fs::read_to_string(out).unwrap()
    };
    let page = show("--count 3");
    assert_eq!(
        page,
        show("--count 3"),
        "the same seed shows the same links"
    );
    // Five of statistics, three a link.
    assert_eq!(pictures_in(&page), 5 + 3 * 3);
    assert!(page.len() < 400_000, "{} bytes", page.len());
    assert!(!page.contains("<script") && !page.contains("NaN"));

    let dataset = Dataset::open(folder.path("data")).unwrap();
    let manifest = dataset.manifest();
    let valid = manifest.totals.status["valid"];
    assert_told(&page, &[&format!("Over all {valid} links with a label")]);
    // The mean number of dominant peaks is the one counted when the data set was made; half
    // precision may change a link or two.
    let (mut links, mut peaks) = (0.0, 0.0);
    for map in &manifest.maps {
        for (k, n) in map.statistics["dominant_peaks"].as_object().unwrap() {
            links += n.as_f64().unwrap();
            peaks += n.as_f64().unwrap() * k.parse::<f64>().unwrap();
        }
    }
    let shown = page.split("protocol: ").nth(1).unwrap();
    assert!(
        (number(shown) - peaks / links).abs() < 0.03,
        "{}",
        &shown[..40]
    );

    let page = show("--links 0,1,2 1,3,19 --sample 50");
    assert!(page.contains("Map 1, transmitter 3, receiver 19"));
    assert!(page.contains("random sample of 50 of the"));
    assert_eq!(pictures_in(&page), 5 + 2 * 3);
}

#[test]
fn links_that_are_not_there_are_told() {
    let folder = Folder::new();
    folder.make("data", &[SETTINGS, "aps"]);
    let maps = folder.maps(0);
    fs::write(folder.path("maps/0.json"), "[[[0,0],[10,0],[10,10]]]").unwrap();
    let (data, out) = (folder.arg("data"), folder.arg("x.html"));

    for (line, told) in [
        ("explain DATA --link 0,9,1", "no link from transmitter 9"),
        (
            "explain DATA --link 0,1,99",
            "that transmitter has 20 links, to receivers: ",
        ),
        ("explain DATA --link 0;1", "MAP,TX,RX"),
        ("explain DATA --link 0,1,1 --tile 50", "settings of tiles"),
        (
            "explain DATA --link 0,1,1 --close-gaps 1",
            "and of the scene",
        ),
        (
            "explain DATA --link 0,1,1 --max-reflections 1",
            "settings of the trace",
        ),
        (
            "explain --map MAPS/0.json --tx 20,20 --rx 30,30 --seed 3",
            "--seed is for",
        ),
        (
            "explain --map MAPS/0.json --tx 20,20 --rx 30,30 --map-id 3",
            "settings of tiles",
        ),
        (
            "explain --map synthetic --tx 20,20 --rx 30,30 --map-id 3",
            "--map-id is for",
        ),
        ("explain DATA --link 0,1,1 --maps MAPS", "buildings differ"),
        ("gallery DATA --links 7,0,0", "no map 7"),
        ("explain", "name a link"),
    ] {
        let line = line.replace("DATA", &data).replace("MAPS", &maps);
        assert_told(&fail(&format!("{line} --out {out}")), &[told]);
    }
    for own in ["manifest.json", "map_0000/aps_db.npy"] {
        let file = folder.path("data").join(own);
        let whole = fs::read(&file).unwrap();
        let told = fail(&format!("gallery {data} --out '{}'", file.display()));
        assert!(told.contains("is a file of a data set"), "{told}");
        assert!(fs::read(&file).unwrap() == whole);
    }
    let error = fail(&format!("explain {data} --link 0,1,1 --out x.png"));
    assert!(error.contains(".html or .svg"), "{error}");
}
