use aps_data::{
    Dataset, DatasetWriter, Error, LinkRows, LinkStatus, Links, MapInput, Part, ProfileRows,
    Samples,
};

use crate::sample::{self, ANGLES, DELAYS, LINKS, RX, Rows, TX};

#[test]
fn link_table_comes_back_in_order() {
    let root = sample::written();
    let map = Dataset::open(root.path()).unwrap().map(2).unwrap();
    assert_eq!(
        (map.tx_m.as_slice(), map.rx_m.as_slice()),
        (TX.as_slice(), RX.as_slice())
    );
    assert_eq!(map.links, [[0, 0], [0, 1], [0, 2], [1, 0], [1, 1], [1, 2]]);
    assert_eq!(map.ends_m(4), (TX[1], RX[1]));
    assert_eq!(map.status, Rows::of(2, 0..LINKS).status);
    assert_eq!(map.fallback, Rows::of(2, 0..LINKS).fallback);
    assert_eq!(map.valid_links().collect::<Vec<_>>(), [0, 1, 2, 4, 5]);
    assert_eq!(map.buildings, *sample::BUILDINGS);
}

#[test]
fn spectra_come_back_relative_to_their_maximum() {
    let root = sample::written();
    let dataset = Dataset::open(root.path()).unwrap();
    let rows = Rows::of(3, 0..LINKS);
    let aps = dataset.map(3).unwrap().aps.unwrap();
    assert_eq!(aps.bins(), ANGLES);
    let mut row = [0.0; ANGLES];
    aps.read_relative_db(4, &mut row);
    assert_eq!(row, [0.0, -3.0, -6.0, -9.0, -12.0]);
    assert_eq!(aps.max_db()[4], rows.aps_db[4 * ANGLES] as f32);
    assert_eq!(aps.argmax().unwrap()[4 * ANGLES + 1].to_f32(), 101.0);
    // The link without a path.
    aps.read_relative_db(3, &mut row);
    assert_eq!(row, [aps_data::FILL_DB as f32; ANGLES]);
    assert_eq!(10_f64.powf(aps_data::FILL_DB / 10.0), 0.0);

    let pdp = dataset.pdp(3).unwrap();
    assert_eq!(pdp.bins(), DELAYS);
    assert!(
        matches!(pdp.samples(), Samples::F32(values) if values[DELAYS - 2..=DELAYS] == [-1.0, 0.0, -8.0])
    );
}

#[test]
fn paths_come_back_to_the_last_bit() {
    let root = sample::written();
    let table = Dataset::open(root.path()).unwrap().paths(1).unwrap();
    let rows = Rows::of(1, 0..LINKS);
    assert!(table.is_same(&rows.paths));
    // Links differ in their numbers of paths, and paths in their numbers of interactions.
    let per_link: Vec<usize> = (0..LINKS).map(|link| table.paths_of(link).len()).collect();
    assert_eq!(per_link, [1, 2, 3, 0, 2, 3]);
    let per_path: Vec<usize> = (0..table.delay_s.len())
        .map(|path| table.interactions_of(path).len())
        .collect();
    assert_eq!(per_path, [0, 0, 1, 0, 1, 2, 0, 1, 0, 1, 2]);
}

#[test]
fn manifest_counts_links_by_reason() {
    let root = tempfile::tempdir().unwrap();
    let split = sample::write(root.path());
    let dataset = Dataset::open(root.path()).unwrap();
    let manifest = dataset.manifest();
    assert_eq!((manifest.totals.maps, manifest.totals.links), (4, 24));
    assert_eq!(manifest.totals.status["valid"], 20);
    assert_eq!(manifest.totals.status["no_path"], 4);
    assert_eq!(manifest.config(), sample::config());
    assert_eq!(manifest.split, split);
    let loaded: Vec<u32> = dataset
        .maps_of(Part::Train)
        .map(|map| map.unwrap().id)
        .collect();
    assert_eq!(loaded, split.train);
    assert!(dataset.verify().is_empty(), "{:?}", dataset.verify());
}

#[test]
fn bytes_do_not_depend_on_the_size_of_a_push() {
    let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    sample::write(a.path());
    let writer = DatasetWriter::open(b.path(), sample::config()).unwrap();
    for id in [3, 1, 0, 2] {
        sample::write_map(&writer, id, 1 + id as usize).unwrap();
    }
    writer.finish(&aps_data::Split::of_maps(0..4, 0)).unwrap();
    assert_eq!(sample::contents(a.path()), sample::contents(b.path()));
}

#[test]
fn maps_written_by_several_threads_are_the_same() {
    let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    sample::write(a.path());
    let writer = DatasetWriter::open(b.path(), sample::config()).unwrap();
    std::thread::scope(|scope| {
        for id in 0..4 {
            let writer = &writer;
            scope.spawn(move || sample::write_map(writer, id, LINKS).unwrap());
        }
    });
    writer.finish(&aps_data::Split::of_maps(0..4, 0)).unwrap();
    assert_eq!(sample::contents(a.path()), sample::contents(b.path()));
}

#[test]
fn listed_links_need_not_be_a_grid() {
    let root = tempfile::tempdir().unwrap();
    let writer = sample::writer(&root);
    let input = MapInput {
        links: Links::List(&[[1, 2], [0, 0]]),
        ..sample::input()
    };
    let mut map = writer.begin_map(7, &input).unwrap();
    map.push(&Rows::of(7, 0..2).as_rows()).unwrap();
    map.finish().unwrap();
    writer.finish(&aps_data::Split::of_maps([7], 0)).unwrap();
    let map = Dataset::open(root.path()).unwrap().map(7).unwrap();
    assert_eq!(map.ends_m(0), (TX[1], RX[2]));
}

#[test]
fn map_without_links_is_a_map() {
    let root = tempfile::tempdir().unwrap();
    let writer = sample::writer(&root);
    let input = MapInput {
        tx_m: &[],
        ..sample::input()
    };
    writer.begin_map(0, &input).unwrap().finish().unwrap();
    writer.finish(&aps_data::Split::of_maps([0], 0)).unwrap();
    let dataset = Dataset::open(root.path()).unwrap();
    assert_eq!(dataset.map(0).unwrap().links.len(), 0);
    assert_eq!(dataset.paths(0).unwrap().delay_s.len(), 0);
}

/// Pushes rows changed by `change` as the first of a map; returns what is wrong with them.
fn refused(change: impl Fn(&mut Rows)) -> String {
    let root = tempfile::tempdir().unwrap();
    let writer = sample::writer(&root);
    let mut map = writer.begin_map(5, &sample::input()).unwrap();
    let mut rows = Rows::of(5, 0..LINKS);
    change(&mut rows);
    let error = map.push(&rows.as_rows()).unwrap_err();
    assert!(matches!(error, Error::Input { map: 5, .. }), "{error:?}");
    // Refused rows leave nothing behind: the right ones may follow.
    map.push(&Rows::of(5, 0..LINKS).as_rows()).unwrap();
    map.finish().unwrap();
    writer.finish(&aps_data::Split::of_maps([5], 0)).unwrap();
    assert!(Dataset::open(root.path()).unwrap().verify().is_empty());
    error.to_string()
}

#[test]
fn rows_that_make_no_sense_are_refused_by_name() {
    type Case<'a> = (&'a dyn Fn(&mut Rows), &'a str);
    let cases: [Case<'_>; 7] = [
        (
            &|rows| rows.aps_db[ANGLES + 2] = f64::NAN,
            "map 5: aps: link 1, bin 2: NaN dB is not a finite value",
        ),
        (
            &|rows| rows.aps_db.truncate(3),
            "map 5: aps: 3 values for 6 links of 5 bins",
        ),
        (
            &|rows| rows.pdp_angle_deg[1] = 1e9,
            "map 5: pdp: link 0, bin 1: 1000000000 is out of range for a place",
        ),
        (
            &|rows| rows.status[3] = LinkStatus::Valid,
            "map 5: paths: link 3 is valid, but has 0 paths",
        ),
        (
            &|rows| rows.status[0] = LinkStatus::OnWall,
            "map 5: paths: link 0 is on_wall, but has 1 paths",
        ),
        (
            &|rows| rows.paths.gain[1][1] = f64::INFINITY,
            "map 5: paths: gain number 3 is inf",
        ),
        (
            &|rows| rows.paths.interaction_id.truncate(1),
            "map 5: paths: interaction_id has 1 values, expected 8",
        ),
    ];
    for (change, message) in cases {
        assert_eq!(refused(change), message);
    }
}

#[test]
fn rows_must_be_what_the_layout_stores() {
    let root = tempfile::tempdir().unwrap();
    let writer = sample::writer(&root);
    let mut map = writer.begin_map(0, &sample::input()).unwrap();
    let rows = Rows::of(0, 0..LINKS);
    let mut refused = |rows: &LinkRows<'_>| map.push(rows).unwrap_err().to_string();
    let without_aps = LinkRows {
        aps: None,
        ..rows.as_rows()
    };
    assert!(refused(&without_aps).contains("aps: missing"));
    let without_paths = LinkRows {
        paths: None,
        ..rows.as_rows()
    };
    assert!(refused(&without_paths).contains("paths: must be given"));
    let without_places = LinkRows {
        aps: Some(ProfileRows {
            db: &rows.aps_db,
            argmax: None,
        }),
        ..rows.as_rows()
    };
    assert!(refused(&without_places).contains("places of the maxima"));
    map.push(&rows.as_rows()).unwrap();
    let more = map.push(&Rows::of(0, 0..1).as_rows()).unwrap_err();
    assert!(more.to_string().contains("more rows than its 6 links"));
}

#[test]
fn positions_and_links_must_exist() {
    let root = tempfile::tempdir().unwrap();
    let writer = sample::writer(&root);
    let begin = |tx_m: &[[f64; 2]], links: Links<'_>| {
        let input = MapInput {
            tx_m,
            links,
            ..sample::input()
        };
        writer.begin_map(0, &input).unwrap_err().to_string()
    };
    assert_eq!(
        begin(&[[0.0, f64::NAN]], Links::Grid),
        "map 0: tx 0 is at (0, NaN) m, outside of the map's image of 10 m x 4 m"
    );
    assert_eq!(
        begin(&TX, Links::List(&[[0, 0], [0, 3]])),
        "map 0: link 1 is [0, 3], but there are 2 tx and 3 rx"
    );
}
