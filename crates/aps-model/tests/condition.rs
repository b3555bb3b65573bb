//! Condition images: those of the data set crate at its size, the same picture at any other.

use aps_data::{ConditionConfig as DataConfig, ConditionImages as DataImages, Raster, RasterGrid};
use aps_model::Error;
use aps_model::candle_core::Device;
use aps_model::condition::{ConditionConfig, ConditionImages, Link, ModelInput, Rasters};

const LINKS: [([f64; 2], [f64; 2]); 3] = [
    ([128.0, 10.0], [30.0, 40.0]),
    ([0.0, 255.0], [200.25, 199.5]),
    ([17.0, 96.0], [17.0, 96.0]),
];

/// Two maps of 256 x 256 pixels with a few buildings.
fn maps() -> [Raster; 2] {
    [0.0, 37.0].map(|shift| {
        let house = |x: f64, y: f64, w: f64, h: f64| {
            let (x, y) = (x + shift, y + shift);
            vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]]
        };
        let buildings = [
            house(20.0, 30.0, 41.0, 17.0),
            house(100.0, 90.0, 5.0, 80.0),
            house(-3.0, 150.0, 30.0, 9.0),
        ];
        Raster::of_outlines(&buildings, RasterGrid::default()).unwrap()
    })
}

fn conditions(maps: &[Raster], image_size: usize) -> ConditionImages {
    spots_of(maps, image_size, ConditionConfig::default().sigma_px)
}

fn spots_of(maps: &[Raster], image_size: usize, sigma_px: f64) -> ConditionImages {
    let pixels = maps.iter().flat_map(|map| map.pixels());
    let pixels: Vec<f32> = pixels.map(|&pixel| pixel.into()).collect();
    let rasters = Rasters {
        pixels: &pixels,
        height: 256,
        width: 256,
        metres_per_pixel: 1.0,
    };
    let config = ConditionConfig {
        image_size,
        sigma_px,
        ..ConditionConfig::default()
    };
    ConditionImages::new(rasters, config, &Device::Cpu).unwrap()
}

fn links() -> Vec<Link> {
    let link = |(i, (tx_m, rx_m))| Link {
        map: i as u32 % 2,
        tx_m,
        rx_m,
    };
    LINKS.into_iter().enumerate().map(link).collect()
}

fn values(conditions: &ConditionImages) -> Vec<f32> {
    let images = conditions.batch(&links()).unwrap();
    images.flatten_all().unwrap().to_vec1().unwrap()
}

#[test]
fn images_of_any_size_are_those_of_the_data_set_bit_for_bit() {
    let maps = maps();
    let sizes = [256, 64, 100, 300].map(|size| (size, 20.0));
    for (size, sigma_px) in sizes.into_iter().chain([(256, 1e-160), (64, 1e-320)]) {
        let config = DataConfig {
            image_size: Some(size),
            sigma_px,
        };
        let expected = links().into_iter().flat_map(|link| {
            let images = DataImages::new(&maps[link.map as usize], config);
            images.batch(&[(link.tx_m, link.rx_m)])
        });
        let expected: Vec<f32> = expected.collect();
        let found = values(&spots_of(&maps, size, sigma_px));
        assert!(found == expected, "{size} px, spots of {sigma_px:e} px");
    }
}

/// Buildings exactly; a spot's average over four pixels differs from its value at their middle by the curvature of the
/// Gaussian, (4^2 - 1) / 24 / 20^2 = 0.0016 of its height an axis.
#[test]
fn a_smaller_image_is_the_average_of_the_large_one() {
    let maps = maps();
    let [large, small] = [256, 64].map(|size| values(&conditions(&maps, size)));
    let mut worst = [0.0_f32; 3];
    for (i, &value) in small.iter().enumerate() {
        let (plane, row, column) = (i / (64 * 64), i / 64 % 64, i % 64);
        let pixel = |j: usize| large[(plane * 256 + 4 * row + j / 4) * 256 + 4 * column + j % 4];
        let average = (0..16).map(pixel).sum::<f32>() / 16.0;
        worst[plane % 3] = worst[plane % 3].max((value - average).abs());
    }
    assert!(worst[0] < 1e-6, "{worst:?}");
    assert!(worst[1] < 0.0035 && worst[2] < 0.0035, "{worst:?}");
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let maps = maps();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.unwrap();
        pool.install(|| values(&conditions(&maps, 48)))
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn what_cannot_be_drawn_is_told() {
    let conditions = conditions(&maps(), 32);
    let [good, ..] = links()[..] else {
        unreachable!()
    };
    let told = |link| match conditions.batch(&[good, link]) {
        Err(Error::Condition(problem)) => problem,
        other => panic!("{other:?}"),
    };
    assert!(told(Link { map: 2, ..good }).contains("link 1"));
    let rx_m = [f64::NAN, 0.0];
    assert!(told(Link { rx_m, ..good }).contains("finite"));

    let rasters = |pixels, height| Rasters {
        pixels,
        height,
        width: 2,
        metres_per_pixel: 1.0,
    };
    let config = ConditionConfig::default();
    let none = ConditionConfig {
        image_size: 0,
        ..config
    };
    for (rasters, config) in [
        (rasters(&[0.0; 5], 2), config),
        (rasters(&[], 2), config),
        (rasters(&[0.0, 1.0, f32::NAN, 0.0], 2), config),
        (rasters(&[0.0; 4], 2), none),
    ] {
        let made = ConditionImages::new(rasters, config, &Device::Cpu);
        assert!(matches!(made, Err(Error::Condition(_))));
    }
}

/// The image of a mirrored link on a mirrored map is the mirrored image, axis by axis.
#[test]
fn a_mirrored_link_has_a_mirrored_image() {
    let (height, width, size) = (64, 128, 32);
    let pixel = |i: usize| f32::from(i % 7 < 3 || (i / 50).is_multiple_of(3));
    let map: Vec<f32> = (0..2 * height * width).map(pixel).collect();
    let rasters = Rasters {
        pixels: &map,
        height,
        width,
        metres_per_pixel: 2.0,
    };
    let pixels = rasters.mirrored();
    assert_eq!(pixels[..map.len()], map);
    let config = ConditionConfig {
        image_size: size,
        ..ConditionConfig::default()
    };
    let all = Rasters {
        pixels: &pixels,
        ..rasters
    };
    let conditions = ConditionImages::new(all, config, &Device::Cpu).unwrap();
    assert_eq!(all.maps(), 4 * rasters.maps());
    let link = Link {
        map: 1,
        tx_m: [30.5, 100.0],
        rx_m: [201.0, 7.25],
    };
    let images = [0, 1, 2, 3].map(|i| link.mirrored(i, rasters.maps(), rasters.far_end_m()));
    let images = conditions.batch(&images).unwrap();
    let values: Vec<f32> = images.flatten_all().unwrap().to_vec1().unwrap();
    let images: Vec<&[f32]> = values.chunks_exact(3 * size * size).collect();
    for (number, image) in images.iter().enumerate() {
        let mirrored = [number & 1 == 1, number & 2 == 2];
        let turn = |i: usize, along: bool| if along { size - 1 - i } else { i };
        for plane in 0..3 {
            for (y, x) in (0..size).flat_map(|y| (0..size).map(move |x| (y, x))) {
                let at = |y: usize, x: usize| (plane * size + y) * size + x;
                let expected = images[0][at(turn(y, mirrored[1]), turn(x, mirrored[0]))];
                let found = image[at(y, x)];
                // Pixels of the map are averaged in another order, positions computed anew.
                let is_close = (found - expected).abs() < 1e-6;
                assert!(is_close, "image {number} at {plane} {y} {x}");
            }
        }
    }
}
