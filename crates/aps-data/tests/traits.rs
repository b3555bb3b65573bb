//! Traits that every public type implements, checked by the compiler. Writers are not copied: each holds a lock or a file.
//! Errors are not copied either: they carry the operating system's error.

use std::fmt::Debug;

use aps_data::*;

fn is_shared<T: Debug + Clone + Send + Sync + 'static>() {}
fn is_sent<T: Debug + Send + 'static>() {}
fn is_error<T: std::error::Error + Send + Sync + 'static>() {}

#[test]
fn types_can_be_shown_copied_and_shared() {
    is_shared::<(Dataset, Manifest, MapEntry, MapData, Profile, PathTable)>();
    is_shared::<(Survey, Plan, Split, DatasetConfig, Layout, Raster)>();
    is_shared::<(ConditionConfig, ConditionImages, LinkStatus)>();
    is_shared::<(LinkRows<'static>, MapInput<'static>)>();
    is_sent::<(DatasetWriter, MapWriter<'static>)>();
    is_error::<Error>();
    is_error::<RasterError>();
}

#[test]
fn no_message_repeats_its_cause() {
    use std::io::Error as IoError;

    let io = || IoError::other("the cause");
    let path = || std::path::PathBuf::from("file");
    let errors: [Box<dyn std::error::Error>; 7] = [
        Box::new(Error::Io {
            action: "read",
            path: path(),
            source: io(),
        }),
        Box::new(Error::Npy {
            path: path(),
            source: npy::NpyError::NotNpy,
        }),
        Box::new(Error::Json {
            path: path(),
            source: serde_json::from_str::<u8>("").unwrap_err(),
        }),
        Box::new(npy::NpyError::from(io())),
        Box::new(propbin::PropbinError::from(io())),
        Box::new(released::Sample::from_npz(b"").unwrap_err()),
        Box::new(released::SampleError::Npy {
            array: "aps_norm",
            source: npy::NpyError::NotNpy,
        }),
    ];
    for error in errors {
        let cause = error.source().map(|cause| cause.to_string());
        let told = error.to_string();
        assert!(cause.is_none_or(|cause| !told.contains(&cause)), "{told}");
    }
}
