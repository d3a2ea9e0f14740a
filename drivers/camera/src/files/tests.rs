//! Folders of pictures on a test bench.

use jde_picture::{Color, Compression};
use jde_schema::Severity;
use jde_schema::bench::Bench;
use tempfile::TempDir;

use super::*;

/// A folder, and the driver that shows it.
struct Fixture {
    bench: Bench<Files>,
    folder: TempDir,
}

impl Fixture {
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
        self.bench.iterate().expect("it iterates");
        let image: &Image = self.bench.exported_in_place("image")?;
        Some((image.data[0], self.bench.exported_at("image")?.as_millis()))
    }

    fn note(&self) -> String {
        let connection: Connection = self.bench.exported("connection").expect("it is exported");
        connection.note.to_string()
    }

    fn warnings(&self) -> Vec<&str> {
        let log = self
            .bench
            .log()
            .iter()
            .filter(|(severity, _)| *severity == Severity::Warn);
        log.map(|(_, text)| &**text).collect()
    }
}

fn grey(level: u8) -> Vec<u8> {
    png_of(4, 2, level)
}

/// A PNG in which every pixel is this grey.
fn png_of(width: u32, height: u32, level: u8) -> Vec<u8> {
    let pixels = vec![level; (width * height) as usize];
    let file = Compression::Png.encode((width, height), Color::Grey, &pixels);
    file.expect("a PNG")
}

#[test]
fn pictures_repeat_in_the_order_of_their_names_at_the_rate() {
    let mut fixture = Fixture::new(&[
        ("b.png", grey(2)),
        ("a.PNG", grey(1)),
        ("c.png", grey(3)),
        ("notes.txt", vec![]),
    ])
    .awake();
    assert!(fixture.note().starts_with("3 pictures of "));
    assert_eq!(fixture.at(0.0), Some((1, 0)));
    assert_eq!(fixture.at(0.09), Some((1, 0)), "the next picture is not due");
    assert_eq!(fixture.at(0.1), Some((2, 100)));
    assert_eq!(fixture.at(0.25), Some((3, 250)));
    assert_eq!(fixture.at(0.3), Some((1, 300)), "the first picture again");
    assert_eq!(fixture.at(10.1), Some((3, 10_100)), "late pictures are skipped");
}

#[test]
fn without_repeat_the_last_picture_stays() {
    let mut fixture = Fixture::new(&[("a.png", grey(1)), ("b.png", grey(2))]);
    fixture.bench.set("repeat", Flag::FALSE);
    fixture.bench.set("rate", 1.0);
    let mut fixture = fixture.awake();
    assert_eq!(fixture.at(0.0), Some((1, 0)));
    assert_eq!(fixture.at(1.0), Some((2, 1000)));
    assert_eq!(fixture.at(5.0), Some((2, 1000)));
    assert_eq!(fixture.note(), "all pictures have been shown");
}

#[test]
fn an_image_has_the_size_and_colours_of_its_file() {
    let jpeg = Compression::Jpeg.encode((32, 16), Color::Rgb, &[200, 100, 50].repeat(32 * 16));
    let fixture = Fixture::new(&[("a.jpg", jpeg.expect("a JPEG"))]);
    let file = fixture.folder.path().join("a.jpg");
    let mut fixture = fixture;
    fixture
        .bench
        .set("path", Text::<1024>::new(file.to_str().expect("a path in UTF-8")));
    let mut fixture = fixture.awake();
    fixture.at(0.5);
    let image: &Image = fixture.bench.exported_in_place("image").expect("it is exported");
    assert_eq!(
        (image.width, image.height, image.step, image.data.len()),
        (32, 16, 96, 1536)
    );
    assert_eq!(image.encoding.as_str(), "rgb8");
    assert!(image.data[0].abs_diff(200) < 5 && image.data[2].abs_diff(50) < 5);
}

#[test]
fn an_unreadable_picture_is_skipped_with_one_warning() {
    let large = png_of(800, 600, 0);
    let mut fixture = Fixture::new(&[
        ("a.png", grey(1)),
        ("b.png", large),
        ("c.jpg", b"no picture".to_vec()),
    ])
    .awake();
    assert_eq!(fixture.at(0.0), Some((1, 0)));
    assert_eq!(fixture.at(0.1), Some((1, 0)));
    for turn in 1..5 {
        fixture.at(f64::from(turn) * 0.3 + 0.1);
        fixture.at(f64::from(turn) * 0.3 + 0.2);
    }
    let warnings = fixture.warnings();
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
fn missing_pictures_are_an_error_with_a_remedy() {
    let refused = |files: &[(&str, Vec<u8>)], path: &str| {
        let mut fixture = Fixture::new(files);
        if path != "folder" {
            fixture.bench.set("path", Text::<1024>::new(path));
        }
        let problems = fixture.bench.inspect().expect("it inspects");
        let awake = fixture.bench.awake();
        let reason = awake
            .and_then(|()| fixture.bench.iterate())
            .expect_err("there are no pictures")
            .reason;
        let messages: Vec<_> = problems.iter().map(|problem| &*problem.words).collect();
        assert_eq!(messages, [&*reason], "an inspection reports the same");
        reason
    };
    assert!(refused(&[], "").contains("path = \"pictures\""));
    assert!(refused(&[("a.txt", vec![])], "folder").contains("no file of it ends in .png, .jpg or .jpeg"));
    assert!(refused(&[], "no/such/folder").starts_with("no/such/folder: No such file"));
    let reason = refused(&[("a.png", png_of(800, 600, 0))], "folder");
    assert!(reason.contains("a.png: it is 800 x 600 pixels"), "{reason}");
}
