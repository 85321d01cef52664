//! `--format npy`: tables as arrays of NumPy, read by the rules of its format.

use std::fs;

use crate::common::Folder;

/// The fields of an array, each with its type, and its records as cells that are written as in a table: a double that
/// is NaN is an empty cell.
#[derive(Debug, PartialEq)]
struct Array {
    fields: Vec<(String, String)>,
    rows: Vec<Vec<String>>,
}

/// Reads an array by the page of NumPy about its format.
fn array(folder: &Folder, name: &str) -> Array {
    let bytes = fs::read(folder.path(name)).unwrap();
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00", "{name}");
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let (header, mut data) = bytes[10..].split_at(length);
    assert!((10 + length).is_multiple_of(64) && header.ends_with(b"\n"), "{name}");
    let header = std::str::from_utf8(header).unwrap().trim_end();
    let (list, rest) = header.strip_prefix("{'descr': [(").and_then(|text| text.split_once(")], ")).unwrap();
    let field = |pair: &str| {
        let (name, kind) = pair.trim_matches('\'').split_once("', '").unwrap();
        (name.to_owned(), kind.to_owned())
    };
    let fields: Vec<(String, String)> = list.split("), (").map(field).collect();
    let count = rest.strip_prefix("'fortran_order': False, 'shape': (").and_then(|rest| rest.strip_suffix(",), }"));
    let mut take = |size: usize| {
        let (cell, rest) = data.split_at(size);
        data = rest;
        cell.to_vec()
    };
    let mut cell = |kind: &str| match kind {
        "<i8" => i64::from_le_bytes(take(8).try_into().unwrap()).to_string(),
        "<f8" => {
            let value = f64::from_le_bytes(take(8).try_into().unwrap());
            if value.is_nan() { String::new() } else { format!("{value:?}") }
        }
        text => {
            let letters = take(4 * text.strip_prefix("<U").unwrap().parse::<usize>().unwrap());
            let letters = letters.chunks(4).map(|four| u32::from_le_bytes(four.try_into().unwrap()));
            letters.take_while(|letter| *letter > 0).map(|letter| char::from_u32(letter).unwrap()).collect()
        }
    };
    let count: usize = count.unwrap().parse().unwrap();
    let rows = (0..count).map(|_| fields.iter().map(|(_, kind)| cell(kind)).collect()).collect();
    assert!(data.is_empty(), "{name} has {} bytes too many", data.len());
    Array { fields, rows }
}

/// Every table of a folder has an array of its columns and numbers, and there are no others. Returns the fields that
/// are no doubles, with the names of their tables.
fn check(folder: &Folder, out: &str) -> Vec<String> {
    let (names, mut others) = (folder.names(out), Vec::new());
    let of = |end: &str| names.iter().filter_map(|name| name.strip_suffix(end)).map(str::to_owned).collect::<Vec<_>>();
    assert!(of(".csv") == of(".npy") && !of(".csv").is_empty(), "{names:?}");
    for name in of(".csv") {
        let (table, array) = (folder.table(&format!("{out}/{name}.csv")), array(folder, &format!("{out}/{name}.npy")));
        assert_eq!(array.fields.iter().map(|field| &*field.0).collect::<Vec<_>>(), table.columns, "{name}");
        assert_eq!(array.rows.len(), table.rows.len(), "{name}");
        for (row, cells) in array.rows.iter().zip(&table.rows) {
            for ((found, cell), (column, kind)) in row.iter().zip(cells).zip(&array.fields) {
                let is_same = match kind.as_str() {
                    "<f8" if !cell.is_empty() => {
                        cell.parse::<f64>().unwrap().to_bits() == found.parse::<f64>().unwrap().to_bits()
                    }
                    _ => found == cell,
                };
                assert!(is_same, "{name}, {column}: {found} and {cell}");
            }
        }
        let is_other = |field: &&(String, String)| field.1 != "<f8";
        others
            .extend(array.fields.iter().filter(is_other).map(|(field, kind)| format!("{name} {field} {}", &kind[..2])));
    }
    others
}

#[test]
fn every_table_of_a_run_is_an_array_too() {
    let folder = Folder::new();
    folder.succeeds("run quartic --set solver.system=doubled --sample-t 0:1:0.1 --format npy --out doubled");
    assert!(check(&folder, "doubled").is_empty());
    assert!(folder.names("doubled").contains(&"branches.npy".to_owned()));
    folder.succeeds("run henon-heiles-megno --set grid.gamma_f=20 --format npy --out windows");
    let others = check(&folder, "windows");
    assert_eq!(others, ["residuals window <i", "trajectory window <i"]);
    // Numbers with more digits are the nearest doubles, and bounds that are not known are NaN.
    folder.succeeds("run quartic-40-digits --set grid.gamma_f=3.0 --sample-t 0,1 --format npy --out digits");
    check(&folder, "digits");
    folder.succeeds(
        "run henon-heiles --set grid.gamma_f=2 --set solver.accuracy=1e-8 --sample-t 0,1 --prove \
                     --format npy --out proved",
    );
    assert!(check(&folder, "proved").contains(&"events event <U".to_owned()));
    assert!(array(&folder, "proved/samples.npy").rows[0].contains(&String::new()));
    // The next run without it leaves none behind, and a failed one has what it has.
    folder.succeeds("run quartic --out doubled");
    assert!(folder.names("doubled").iter().all(|name| !name.ends_with(".npy")));
    folder.fails("run horizon --set solver.accuracy=1e-8 --format npy --out failed", 4);
    check(&folder, "failed");
    assert!(folder.names("failed").contains(&"until_failure.npy".to_owned()));
    folder.refuses(&[
        ("run quartic --format npy --stdout", 2, "--format"),
        ("run quartic --format parquet", 2, "csv, npy"),
    ]);
}

#[test]
fn tables_of_a_sweep_are_arrays_whole_and_merged() {
    let folder = Folder::new();
    let table = "run kepler --quiet --set grid.windows=8 --vary initial.x=0.5,0.7,abc --vary scheme.sbp=GLL16,GLL20 \
                 --vary grid.n_gamma=16,20 --sample-t 0:1:0.5 --format npy";
    folder.succeeds(&format!("{table} --out whole"));
    let others = check(&folder, "whole");
    let of_runs = "row <i,initial.x <U,scheme.sbp <U,grid.n_gamma <i,status <U,exit_code <i,ended_by <U,verdict <U,\
                   message <U";
    let of_runs = of_runs.split(',').map(|field| format!("runs {field}"));
    let of_others = ["runs-events row <i", "runs-events event <U", "runs-samples row <i"].map(str::to_owned);
    assert_eq!(others, of_others.into_iter().chain(of_runs).collect::<Vec<_>>());
    for k in 1..=2 {
        folder.succeeds(&format!("{table} --part {k}/2 --out p{k}"));
    }
    folder.succeeds("merge p1 p2 --out merged --quiet --format npy");
    for name in ["runs.npy", "runs-events.npy", "runs-samples.npy"] {
        let [whole, merged] = ["whole", "merged"].map(|out| fs::read(folder.path(out).join(name)).unwrap());
        assert!(whole == merged, "{name}");
    }
}
