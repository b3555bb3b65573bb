//! The description of the tables in Croissant 1.0 (MLCommons), which search engines and loaders read.

use serde_json::{Value, json};

use super::Written;
use super::card::{About, split_of};
use super::columns::{Column, Values, folder_of};

/// Types of columns in the format's words, and if there are many values a row.
fn type_of(values: &Values) -> (&'static str, bool) {
    match values {
        Values::Integers(_) => ("sc:Integer", false),
        Values::Floats(_) | Values::Doubles(_) => ("sc:Float", false),
        Values::Texts(_) | Values::Bytes(_) => ("sc:Text", false),
        Values::FloatLists(..) | Values::DoubleLists(..) => ("sc:Float", true),
    }
}

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
    let records = about.parts().map(|part| {
        let split = split_of(part);
        let field = |column: &Column| field(split, column);
        json!({
            "@type": "cr:RecordSet",
            "@id": format!("links-{split}"),
            "description": format!("A link a row, of the maps of the part {split}."),
            "field": about.columns.iter().map(field).collect::<Vec<_>>(),
        })
    });
    json!({
        "@context": context(),
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": "angle-power-spectra",
        "description": "Radio links in city maps with the angle power spectra that their propagation paths make.",
        "license": "other",
        "url": ".",
        "version": env!("CARGO_PKG_VERSION"),
        "distribution": files.chain(sets).collect::<Vec<_>>(),
        "recordSet": records.collect::<Vec<_>>(),
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

fn field(split: &str, column: &Column) -> Value {
    let (kind, repeated) = type_of(&column.values);
    let unit = match column.unit {
        "" => String::new(),
        unit => format!(" [{unit}]"),
    };
    let mut field = json!({
        "@type": "cr:Field",
        "@id": format!("links-{split}/{}", column.name),
        "description": format!("{}{unit}", column.meaning),
        "dataType": kind,
        "source": { "fileSet": { "@id": split }, "extract": { "column": column.name } },
    });
    if repeated {
        field["repeated"] = json!(true);
    }
    field
}

/// The names that the format asks for.
fn context() -> Value {
    json!({
        "@language": "en",
        "@vocab": "https://schema.org/",
        "citeAs": "cr:citeAs",
        "column": "cr:column",
        "conformsTo": "dct:conformsTo",
        "cr": "http://mlcommons.org/croissant/",
        "data": { "@id": "cr:data", "@type": "@json" },
        "dataBiases": "cr:dataBiases",
        "dataCollection": "cr:dataCollection",
        "dataType": { "@id": "cr:dataType", "@type": "@vocab" },
        "dct": "http://purl.org/dc/terms/",
        "examples": { "@id": "cr:examples", "@type": "@json" },
        "extract": "cr:extract",
        "field": "cr:field",
        "fileObject": "cr:fileObject",
        "fileProperty": "cr:fileProperty",
        "fileSet": "cr:fileSet",
        "format": "cr:format",
        "includes": "cr:includes",
        "isLiveDataset": "cr:isLiveDataset",
        "jsonPath": "cr:jsonPath",
        "key": "cr:key",
        "md5": "cr:md5",
        "parentField": "cr:parentField",
        "path": "cr:path",
        "personalSensitiveInformation": "cr:personalSensitiveInformation",
        "recordSet": "cr:recordSet",
        "references": "cr:references",
        "regex": "cr:regex",
        "repeated": "cr:repeated",
        "replace": "cr:replace",
        "sc": "https://schema.org/",
        "separator": "cr:separator",
        "source": "cr:source",
        "subField": "cr:subField",
        "transform": "cr:transform",
    })
}
