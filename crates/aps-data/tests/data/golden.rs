//! Made by `tests/golden/raster.py` of the workspace.

use aps_data::{ConditionConfig, ConditionImages, Raster, RasterGrid, npy};

const SIZE: usize = 64;

fn golden(name: &str) -> String {
    format!("{}/../../tests/golden/{name}", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn buildings_are_drawn_as_pillow_draws_them() {
    let text = std::fs::read_to_string(golden("raster_polygons.json")).unwrap();
    let images: Vec<Vec<Vec<[f64; 2]>>> = serde_json::from_str(&text).unwrap();
    let drawn = npy::read::<u8>(golden("raster_pillow.npy")).unwrap();
    assert_eq!(drawn.shape, [images.len(), SIZE, SIZE]);
    for (polygons, expected) in images.iter().zip(drawn.data.chunks_exact(SIZE * SIZE)) {
        let raster = Raster::of_outlines(polygons, RasterGrid::square(SIZE, SIZE as f64)).unwrap();
        assert_eq!(raster.pixels(), expected);
    }
}

#[test]
fn spots_are_those_of_numpy() {
    let expected = npy::read::<f32>(golden("raster_condition.npy")).unwrap();
    assert_eq!(expected.shape, [2, SIZE, SIZE]);
    let open_ground = Raster::empty(RasterGrid::square(SIZE, SIZE as f64)).unwrap();
    let images = ConditionImages::new(&open_ground, ConditionConfig::default());
    let image = images.batch(&[([12.0, 50.0], [40.5, 3.25])]);
    let differences = image[SIZE * SIZE..]
        .iter()
        .zip(&expected.data)
        .map(|(a, b)| a.to_bits().abs_diff(b.to_bits()));
    assert!(
        differences.max().unwrap() <= 1,
        "more than the last bit differs"
    );
}
