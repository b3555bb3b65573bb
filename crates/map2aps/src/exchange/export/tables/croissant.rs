//! The description of the tables in Croissant 1.0 (MLCommons), which search engines and loaders read.

use serde_json::{Value, json};

use super::card::{About, CITATION, LICENCE, split_of};
use super::columns::{Column, folder_of};
use super::written::Written;

/// The description, in JSON-LD.
pub fn description(about: &About<'_>, buildings: &Written) -> Value {
    let files = about.written.iter().chain([buildings]).map(object);
    let sets = about.parts().map(|part| {
        let (id, folder) = (split_of(part), folder_of(Some(part)));
        json!({
            "@type": "cr:FileSet",
            "@id": id,
            "encodingFormat": "application/x-parquet",
            "includes": format!("data/{folder}/*.parquet"),
        })
    });
    let links = about.parts().map(|part| {
        let split = split_of(part);
        let description = format!("A link a row, of the maps of the part {split}.");
        let source = json!({ "fileSet": { "@id": split } });
        let id = format!("links-{split}");
        records(&id, &description, &source, about.columns)
    });
    let source = json!({ "fileObject": { "@id": buildings.name } });
    let description = "A map a row, with the image of its buildings.";
    let mut maps = records("buildings", description, &source, about.buildings);
    maps["key"] = json!({ "@id": "buildings/map" });
    json!({
        "@context": context(),
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": "angle-power-spectra",
        "description": "Radio links in city maps with the angle power spectra that their propagation paths make.",
        "license": LICENCE,
        "citeAs": CITATION,
        "creator": {
            "@type": "sc:Organization",
            "name": "The contributors of Map2APS in Rust",
            "description": "They wrote the program that made the tables; whoever ran it is not known to it.",
        },
        "url": ".",
        "version": env!("CARGO_PKG_VERSION"),
        "distribution": files.chain(sets).collect::<Vec<_>>(),
        "recordSet": links.chain([maps]).collect::<Vec<_>>(),
    })
}

/// A set of records of files with some columns.
fn records(id: &str, description: &str, source: &Value, columns: &[Column]) -> Value {
    let field = |column: &Column| field(id, source, column);
    json!({
        "@type": "cr:RecordSet",
        "@id": id,
        "description": description,
        "field": columns.iter().map(field).collect::<Vec<_>>(),
    })
}

fn object(file: &Written) -> Value {
    json!({
        "@type": "cr:FileObject",
        "@id": file.name,
        "name": file.name,
        "contentUrl": file.name,
        "contentSize": format!("{} B", file.bytes),
        "encodingFormat": "application/x-parquet",
        "sha256": file.sha256,
    })
}

fn field(records: &str, source: &Value, column: &Column) -> Value {
    let [.., kind] = column.values.types();
    let unit = match column.unit {
        "" => String::new(),
        unit => format!(" [{unit}]"),
    };
    let mut source = source.clone();
    source["extract"] = json!({ "column": column.name });
    let mut field = json!({
        "@type": "cr:Field",
        "@id": format!("{records}/{}", column.name),
        "description": format!("{}{unit}", column.meaning),
        "dataType": kind,
        "source": source,
    });
    if column.values.are_lists() {
        field["repeated"] = json!(true);
    }
    field
}

/// Reads the names that the format asks for.
fn context() -> Value {
    serde_json::from_str(include_str!("context.json")).expect("the file is JSON")
}
