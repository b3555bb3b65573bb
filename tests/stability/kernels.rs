//! Worst errors of the kernels against 32 digits.

use aps_tests::ulps::worst_errors;

/// Each kernel keeps the error it has been given a bound for, in ulps (2.2e-16): a regression of a
/// kernel's accuracy fails here. The two of diffraction are approximations made for 1e-10, which is
/// 1e6 ulps; gains lose what a double loses of a phase of 7e4 rad (1 km). The reflection coefficient is
/// good to two ulps of 1; next to a permittivity of 1, where it nearly vanishes, that is 1e5 of itself. So it is with dB near 0, of a
/// sum of powers near 1, and with targets near 0. The maximum over a continuous delay is made for 1e-6 dB,
/// 1e9 ulps.
#[test]
fn kernels_keep_their_worst_errors() {
    let bounds = [
        ("transition function F", 2e5),
        ("diffraction coefficient D / sqrt(L)", 4e6),
        ("reflection coefficient", 3e5),
        ("gain of free space, phase included", 9e4),
        ("delay kernel, direct", 7.0),
        ("maximum over a continuous delay", 1e8),
        ("array response, linear, direct", 8e3),
        ("array response, circular, direct", 2.5e3),
        ("array response, linear, tables", 1.5e4),
        ("array response, circular, tables", 7e3),
        ("power to dB", 1e3),
        ("dB to relative power", 20.0),
        ("standardised target", 1e4),
        ("deviation of a training split", 40.0),
        ("MAE", 3.0),
        ("MSE", 4.0),
        ("NMSE", 5.0),
        ("NMSE [dB]", 5.0),
        ("PSNR [dB]", 1.5),
        ("cosine similarity", 4.0),
    ];
    let errors = worst_errors();
    assert_eq!(errors.len(), bounds.len());
    for (error, (kernel, ulps)) in errors.iter().zip(bounds) {
        eprintln!("{error:?}");
        assert_eq!(error.kernel, kernel);
        assert!(error.points > 2 && error.relative_ulps <= ulps, "{error:?}");
        assert!(ulps <= 3.0 * error.relative_ulps, "loose: {error:?}");
    }
}
