//! Prints how far each numerical kernel is from its value in 32 digits, at worst, as a table:
//!
//! ```sh
//! cargo run --release -p aps-tests --example worst_errors
//! ```

fn main() {
    println!(
        "| crate | kernel | worst relative [ulp] | worst absolute [ulp of scale] | at | points |"
    );
    println!("|---|---|---|---|---|---|");
    for e in aps_tests::ulps::worst_errors() {
        println!(
            "| {} | {} | {:.1} | {:.1} | {} | {} |",
            e.of, e.kernel, e.relative_ulps, e.absolute_ulps, e.at, e.points
        );
    }
}
