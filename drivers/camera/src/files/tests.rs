//! Folders of pictures on the bench.

use jde_schema::Severity;
use jde_schema::bench::Bench;
use png::ColorType;
use tempfile::TempDir;

use super::*;
use crate::picture::tests::{jpeg_of, png_of};

/// A folder, and the driver that shows it.
struct Show {
    bench: Bench<Files>,
    folder: TempDir,
}

impl Show {
    fn new(files: &[(&str, Vec<u8>)]) -> Self {
        let folder = TempDir::new().expect("a folder");
        for (name, bytes) in files {
            fs::write(folder.path().join(name), bytes).expect("a file");
        }
        let mut bench = Bench::new();
        bench.set(
            "path",
            Text::<1024>::new(folder.path().to_str().expect("a path in UTF-8")),
        );
        Self { bench, folder }
    }

    fn awake(mut self) -> Self {
        self.bench.awake().expect("there are pictures");
        self
    }

    /// The grey value shown at a time, and the time at which it was first shown, ms.
    fn at(&mut self, seconds: f64) -> Option<(u8, u128)> {
        self.bench.set_now(Duration::from_secs_f64(seconds));
        self.bench.iterate().expect("it shows");
        let image: &Image = self.bench.exported_in_place("image")?;
        Some((image.data[0], self.bench.exported_at("image")?.as_millis()))
    }

    fn note(&self) -> String {
        let connection: Connection = self.bench.exported("connection").expect("it is told");
        connection.note.to_string()
    }

    fn warnings(&self) -> Vec<&str> {
        let log = self
            .bench
            .log()
            .iter()
            .filter(|(severity, _)| *severity == Severity::Warn);
        log.map(|(_, words)| &**words).collect()
    }
}

fn grey(level: u8) -> Vec<u8> {
    png_of(4, 2, ColorType::Grayscale, &[level])
}

#[test]
fn pictures_come_in_the_order_of_their_names_at_the_rate_and_again() {
    let mut show = Show::new(&[
        ("b.png", grey(2)),
        ("a.PNG", grey(1)),
        ("c.png", grey(3)),
        ("notes.txt", vec![]),
    ])
    .awake();
    assert!(show.note().starts_with("3 pictures of "));
    assert_eq!(show.at(0.0), Some((1, 0)));
    assert_eq!(show.at(0.09), Some((1, 0)), "the next is not due");
    assert_eq!(show.at(0.1), Some((2, 100)));
    assert_eq!(show.at(0.25), Some((3, 250)));
    assert_eq!(show.at(0.3), Some((1, 300)), "the first again");
    assert_eq!(show.at(10.1), Some((3, 10_100)), "late ones do not pile up");
}

#[test]
fn without_repeat_the_last_stays() {
    let mut show = Show::new(&[("a.png", grey(1)), ("b.png", grey(2))]);
    show.bench.set("repeat", Flag::FALSE);
    show.bench.set("rate", 1.0);
    let mut show = show.awake();
    assert_eq!(show.at(0.0), Some((1, 0)));
    assert_eq!(show.at(1.0), Some((2, 1000)));
    assert_eq!(show.at(5.0), Some((2, 1000)));
    assert_eq!(show.note(), "all pictures have been shown");
}

#[test]
fn an_image_is_told_as_it_is() {
    let show = Show::new(&[("a.jpg", jpeg_of(32, 16, [200, 100, 50]))]);
    let file = show.folder.path().join("a.jpg");
    let mut show = show;
    show.bench
        .set("path", Text::<1024>::new(file.to_str().expect("a path in UTF-8")));
    let mut show = show.awake();
    show.at(0.5);
    let image: &Image = show.bench.exported_in_place("image").expect("it is shown");
    assert_eq!(
        (image.width, image.height, image.step, image.data.len()),
        (32, 16, 96, 1536)
    );
    assert_eq!(image.encoding.as_str(), "rgb8");
    assert!(image.data[0].abs_diff(200) < 5 && image.data[2].abs_diff(50) < 5);
}

#[test]
fn a_picture_that_is_none_is_left_out_and_told_once() {
    let large = png_of(800, 600, ColorType::Grayscale, &[0]);
    let mut show = Show::new(&[
        ("a.png", grey(1)),
        ("b.png", large),
        ("c.jpg", b"no picture".to_vec()),
    ])
    .awake();
    assert_eq!(show.at(0.0), Some((1, 0)));
    assert_eq!(show.at(0.1), Some((1, 0)));
    for turn in 1..5 {
        show.at(f64::from(turn) * 0.3 + 0.1);
        show.at(f64::from(turn) * 0.3 + 0.2);
    }
    let warnings = show.warnings();
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(
        warnings[0].contains("b.png: it is 800 x 600 pixels"),
        "{warnings:?}"
    );
    assert!(
        warnings[1].contains("c.jpg: it is neither a PNG nor a JPEG"),
        "{warnings:?}"
    );
}

#[test]
fn nothing_to_show_is_an_error_that_says_what_to_do() {
    let refused = |files: &[(&str, Vec<u8>)], path: &str| {
        let mut show = Show::new(files);
        if path != "folder" {
            show.bench.set("path", Text::<1024>::new(path));
        }
        let found = show.bench.inspect().expect("it inspects");
        let awake = show.bench.awake();
        let reason = awake
            .and_then(|()| show.bench.iterate())
            .expect_err("there is nothing")
            .reason;
        let said: Vec<_> = found.iter().map(|problem| &*problem.words).collect();
        assert_eq!(said, [&*reason], "an inspection says the same");
        reason
    };
    assert!(refused(&[], "").contains("path = \"pictures\""));
    assert!(refused(&[("a.txt", vec![])], "folder").contains("no file of it ends in .png, .jpg or .jpeg"));
    assert!(refused(&[], "no/such/folder").starts_with("no/such/folder: No such file"));
    let words = refused(
        &[("a.png", png_of(800, 600, ColorType::Grayscale, &[0]))],
        "folder",
    );
    assert!(words.contains("a.png: it is 800 x 600 pixels"), "{words}");
}
