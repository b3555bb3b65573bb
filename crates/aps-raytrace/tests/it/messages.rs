//! Messages and settings of the public types.

use aps_raytrace::*;

/// Feature `serde` is on in the workspace: package `aps-tests` asks for it.
#[cfg(feature = "serde")]
#[test]
fn records_and_settings_survive_json() {
    let scene = Scene::from_radiomapseer("[[[40, 40], [60, 40], [60, 60], [40, 60]]]").unwrap();
    let config = TraceConfig {
        material: Material::Dielectric {
            relative_permittivity: 3.0,
            conductivity_s_per_m: 0.5,
        },
        ..TraceConfig::default()
    };
    let tracer = Tracer::new(&scene, config.clone()).unwrap();
    let (tx, rx) = (glam::DVec2::new(20.0, 70.0), glam::DVec2::new(50.0, 70.0));
    let paths = tracer.trace(tx, rx).unwrap().paths;
    assert!(paths.iter().any(|path| !path.interactions.is_empty()));
    let text = serde_json::to_string(&(&config, &paths)).unwrap();
    let read: (TraceConfig, Vec<PathRecord>) = serde_json::from_str(&text).unwrap();
    assert_eq!(read.0, config);
    // serde_json rounds the last bit of some numbers unless it is asked not to.
    assert_eq!(read.1.len(), paths.len());
    for (read, path) in read.1.iter().zip(&paths) {
        assert_eq!(read.interactions, path.interactions);
        assert!((read.gain - path.gain).norm() <= 1e-15 * path.gain.norm());
    }
}

#[test]
fn no_message_repeats_its_cause() {
    let config = ConfigError::DynamicRange(f64::NAN);
    let terminal = TerminalError::NotFinite(f64::NAN, 0.0);
    let errors: [Box<dyn std::error::Error>; 4] = [
        Box::new(SceneError::Material {
            building: 0,
            source: config,
        }),
        Box::new(ConfigError::Corner(terminal)),
        Box::new(TraceError::Transmitter(terminal)),
        Box::new(TraceError::Receiver(terminal)),
    ];
    for error in errors {
        let cause = error.source().expect("a cause").to_string();
        assert!(!error.to_string().contains(&cause), "{error}");
    }
}

#[test]
fn a_material_is_told_with_the_carriers_that_its_table_states() {
    let at = |frequency_hz, material| {
        let config = TraceConfig {
            frequency_hz,
            material,
            ..TraceConfig::default()
        };
        config.material_out_of_range().is_some()
    };
    for (frequency_hz, is_outside) in [(923e6, true), (1e9, false), (100e9, false), (300e9, true)] {
        let of_concrete = at(frequency_hz, Material::Concrete);
        assert_eq!(of_concrete, is_outside, "{frequency_hz}");
        assert!(!at(frequency_hz, Material::PerfectConductor));
    }
    let config = TraceConfig {
        frequency_hz: 299_792_458.0,
        ..TraceConfig::default()
    };
    assert_eq!(config.wavelength_m(), 1.0);
}
