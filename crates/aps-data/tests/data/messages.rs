use aps_data::*;

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
