//! The faults of files that are not application files, and the format of faults.

use std::path::Path;

use jde_app::{FaultLocation, Faults, Override, load};

use crate::catalogue::{self, DescribedPlugins, check};

fn refused(path: &Path) -> Faults {
    load(path, &[], &DescribedPlugins).expect_err("a file that cannot be an application")
}

#[test]
fn a_good_file_loads() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/apps/good.toml");
    let application = load(&file, &[], &DescribedPlugins).unwrap_or_else(|faults| panic!("{faults}"));
    assert_eq!(application.path, file);
}

#[test]
fn a_missing_file_is_reported_with_the_nearest_name_in_its_folder() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/apps/godo.toml");
    let shown = file.display().to_string();
    assert_eq!(
        refused(&file).to_string(),
        format!(
            "{shown}: there is no such file\n    help: did you mean `{}`?",
            shown.replace("godo", "good")
        )
    );
    assert_eq!(
        refused(Path::new("/nowhere/at/all.toml")).to_string(),
        "/nowhere/at/all.toml: there is no such file"
    );
}

#[test]
fn a_folder_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    assert_eq!(
        refused(folder.path()).to_string(),
        format!(
            "{}: this is a folder\n    help: give the path of an application file in it",
            folder.path().display()
        )
    );
}

#[test]
fn bytes_that_are_not_utf8_are_refused_with_their_position() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("latin.toml");
    std::fs::write(&file, b"name = \"x\"\ndoc = \"ni\xf1o\"\n").expect("a written file");
    assert_eq!(
        refused(&file).to_string(),
        format!(
            "{}:2:10: this byte is not UTF-8, which an application file must be\n    help: save the file as UTF-8",
            file.display()
        )
    );
}

#[test]
fn a_file_that_is_too_large_is_refused_with_one_fault() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("noise.toml");
    // A linear congruential generator (Knuth's MMIX): every run reads the same noise.
    let mut state = 7u64;
    let noise: Vec<u8> = (0..10 << 20)
        .map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 56) as u8
        })
        .collect();
    std::fs::write(&file, noise).expect("a written file");
    assert_eq!(
        refused(&file).to_string(),
        format!(
            "{}: it has more than 4 MiB, so this is not an application file\n    help: give the path of an application file",
            file.display()
        )
    );
}

#[test]
fn text_that_is_not_toml_is_refused_with_few_faults() {
    for noise in [
        "]", "=", "[[[[", "\"", "a.b.", "x = [", "\u{0}", "{", "'''", "é=1\n",
    ] {
        let text = noise.repeat((1 << 18) / noise.len());
        let faults = catalogue::read(&text, &[]).expect_err(noise);
        assert!(
            faults.list().len() <= 10,
            "{noise}: {} faults",
            faults.list().len()
        );
        assert!(
            faults.to_string().len() < 4000,
            "{noise}: {} bytes",
            faults.to_string().len()
        );
        assert!(
            faults.list().iter().all(|fault| fault.line().is_some()),
            "{noise}"
        );
    }
}

#[test]
fn every_syntax_fault_has_its_position() {
    check(
        &[
            ("name    = \"safe-navigation\"", "name = safe"),
            ("mission = \"example.mission\"", "mission \"example.mission\""),
            ("[schemas.stop]", "[schemas.stop"),
        ],
        r#"
apps/good.toml:2:8: this is not TOML: string values must be quoted, expected literal string
apps/good.toml:4:9: this is not TOML: key with no value, expected `=`
apps/good.toml:23:14: this is not TOML: unclosed table, expected `]`
"#,
    );
}

#[test]
fn a_list_that_is_not_closed_is_one_fault() {
    check(
        &[("[\"laser\"]", "[\"laser\"")],
        "apps/good.toml:20:1: this is not TOML: missing comma between array elements, expected `,`",
    );
}

#[test]
fn a_duplicate_name_is_one_fault() {
    check(
        &[("[schemas.vff]", "[schemas.stop]")],
        r#"
apps/good.toml:28:10: there is a table `stop` already
    help: give each its own name, or merge the two tables
"#,
    );
    check(
        &[("period      = \"75ms\"", "period = \"75ms\"\nperiod = \"80ms\"")],
        r#"
apps/good.toml:18:1: there is a key `period` already
    help: keep one of the two
"#,
    );
}

#[test]
fn all_faults_are_reported_in_the_order_of_the_file_with_options_last() {
    let edits = [
        ("type  = \"sim/robot\"", "type  = \"sim/robo\""),
        ("name    = \"safe-navigation\"", "nam = \"x\""),
        ("\"400 mm/s\"", "\"400 mm\""),
        ("dwell = \"500ms\"", "dwell = 0"),
    ];
    let faults = catalogue::read(&catalogue::edited(&edits), &["goon.sped=1"]).expect_err("five faults");
    let lines: Vec<_> = faults.list().iter().map(|fault| fault.line()).collect();
    assert_eq!(lines, [Some(2), Some(7), Some(21), Some(35), None]);
    assert_eq!(
        faults.list()[4].location,
        FaultLocation::Option("--set goon.sped=1".to_owned())
    );
}

#[test]
fn a_location_has_a_column_in_characters_and_a_span_in_bytes() {
    let text = "# ñandú\nroots = [\"ñandú\", \"gato\"]\n[schemas]\n";
    let faults = catalogue::read(text, &[]).expect_err("unknown schemas");
    let FaultLocation::Text {
        line, column, span, ..
    } = &faults.list()[1].location
    else {
        panic!("{faults}");
    };
    assert_eq!((*line, *column), (2, 19));
    assert_eq!(text.get(span.clone()), Some("\"gato\""));
}

#[test]
fn many_faults_are_counted_and_only_the_first_are_kept() {
    let text: String = (0..1000).map(|n| format!("x{n} = 1\n")).collect();
    let faults = catalogue::read(&text, &[]).expect_err("unknown keys");
    assert_eq!((faults.list().len(), faults.count()), (200, 1002));
    assert!(faults.to_string().ends_with("\nand 962 more"), "{faults}");
}

#[test]
fn an_application_with_too_many_schemas_is_refused() {
    let text: String = (0..10_001)
        .map(|n| format!("[schemas.s{n}]\ntype = \"goon\"\n"))
        .collect();
    let faults = catalogue::read(&text, &[]).expect_err("too many");
    assert!(
        faults
            .list()
            .iter()
            .any(|fault| fault.message.contains("`schemas` has 10001 entries")),
        "{faults}"
    );
}

#[test]
fn a_long_text_is_shortened_in_a_message() {
    let long = "x".repeat(100_000);
    let faults = catalogue::faults(&[("\"sim/robot\"", &format!("\"{long}\""))]);
    assert!(faults.len() < 1000, "{} bytes", faults.len());
    assert!(faults.contains("xxx...`"), "{faults}");
}

#[test]
fn an_option_has_a_schema_a_variable_and_a_value() {
    let parse = |text: &str| text.parse::<Override>();
    assert_eq!(
        parse("goon.speed = \"0.3 m/s\""),
        Ok(Override {
            schema: "goon".to_owned(),
            variable: "speed".to_owned(),
            value: "\"0.3 m/s\"".to_owned(),
            folder: std::env::current_dir().expect("a folder"),
            place: None,
        })
    );
    assert_eq!(
        parse("a.b=c=d.e").map(|option| option.value),
        Ok("c=d.e".to_owned())
    );
    for text in ["", "goon", "goon.speed", "goon=3", ".speed=3", "goon.=3", "=3"] {
        assert_eq!(
            parse(text),
            Err(format!(
                "`{text}` is not an option: write schema.variable=value, such as goon.fast=\"0.3 m/s\""
            ))
        );
    }
}

/// A missing character or line causes at most a fault, never a panic. The position of each fault is within
/// the text.
#[test]
fn a_file_with_a_missing_piece_is_read_or_refused() {
    let good = catalogue::GOOD;
    let characters = good.char_indices().map(|(at, c)| at..at + c.len_utf8());
    let lines = good.lines().map(|line| {
        let start = line.as_ptr() as usize - good.as_ptr() as usize;
        start..start + line.len()
    });
    for piece in characters.chain(lines) {
        let text = [&good[..piece.start], &good[piece.end..]].concat();
        let Err(faults) = catalogue::read(&text, &[]) else {
            continue;
        };
        assert!(!faults.list().is_empty(), "{text}");
        for fault in faults.list() {
            assert!(!fault.message.is_empty() && fault.message.len() < 500, "{fault}");
            if let FaultLocation::Text { line, span, .. } = &fault.location {
                assert!(text.get(span.clone()).is_some(), "{fault} at {span:?} of\n{text}");
                assert_eq!(*line, text[..span.start].matches('\n').count() + 1, "{fault}");
            }
        }
    }
}
