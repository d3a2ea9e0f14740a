//! Compressed pictures in both directions.

use jde_picture::{Color, Compression, Picture};
use jde_schema::types::CompressedImage;

use super::*;
use crate::Topics;
use crate::topics::{Publication, Subscription};

fn image() -> Box<Image> {
    let mut image = Image::boxed();
    image.header = Header::new(Duration::from_millis(2), "eye");
    image.encoding = Text::new("bgr8");
    (image.height, image.width, image.step) = (1, 2, 6);
    image.data.extend_from_slice(&[1, 2, 3, 4, 5, 6]).unwrap();
    image
}

fn compressed(file: &[u8]) -> Box<CompressedImage> {
    let mut message = CompressedImage::boxed();
    message.header = Header::new(stamp(), "eye");
    message.format = Text::new("jpeg");
    message.data.extend_from_slice(file).unwrap();
    message
}

fn publication(compressed: &str) -> Publication {
    Publication {
        compressed: Text::truncated(compressed),
        frame: Text::new("camera"),
        ..Publication::DEFAULT
    }
}

const SUBSCRIPTION: Subscription = Subscription {
    compressed: Flag::TRUE,
    stale: 0.0,
    ..Subscription::DEFAULT
};

#[test]
fn a_picture_is_published_compressed_in_the_words_of_ros() {
    let address = unused_address();
    let session = open_router(&address);
    let entry = Entry::new::<Image>("publish", "image/compressed").settings(&publication("png"));
    let mut fixture = Fixture::<Topics>::with_lists(&address, &[entry]).awake();
    fixture.until_note(Connection::CONNECTED, &address);
    let published = listen::<CompressedImage>(&session, "/image/compressed");
    fixture.bench.import("image/compressed", &*image());
    let mut sample = None;
    fixture.until(|_| {
        sample = published.try_recv().unwrap();
        sample.is_some()
    });
    let mut message = CompressedImage::boxed();
    Codec::new()
        .decode_into(&[&sample.unwrap().payload().to_bytes()], &mut *message)
        .unwrap();
    assert_eq!(message.format, "bgr8; png compressed bgr8");
    assert_eq!(message.header.frame_id, "camera");
    assert!(message.header.stamp.sec > 1_700_000_000, "it is wall-clock time");
    assert_eq!(Picture::read(&message.data).unwrap().rgb, [3, 2, 1, 6, 5, 4]);

    let mut depth = image();
    depth.encoding = Text::new("32FC1");
    (depth.width, depth.step) = (1, 4);
    depth.data.clear();
    depth.data.extend_from_slice(&1_f32.to_le_bytes()).unwrap();
    fixture.bench.import("image/compressed", &*depth);
    fixture.until_logged("`image/compressed` in `publish`: its pixels are \"32FC1\"");
    fixture.bench.import("image/compressed", &*image());
    fixture.until(|_| published.try_recv().unwrap().is_some());
}

#[test]
fn a_compressed_picture_is_exported_and_what_is_none_is_refused_once() {
    let address = unused_address();
    let session = open_router(&address);
    let entry = Entry::new::<Image>("subscribe", "camera").settings(&SUBSCRIPTION);
    let mut fixture = Fixture::<Topics>::with_lists(&address, &[entry]).awake();
    fixture.until_note(Connection::CONNECTED, &address);
    let large = vec![0; 800 * 600];
    let large = Compression::Png.encode((800, 600), Color::Grey, &large).unwrap();
    for (file, reason) in [
        (&b"\xff\xd8 is no jpeg"[..], "/camera: "),
        (&b"GIF89a"[..], "/camera: it is neither a PNG nor a JPEG"),
        (&large[..], "/camera: it is 800 x 600 pixels"),
    ] {
        let message = compressed(file);
        for _ in 0..2 {
            fixture.until(|bench| {
                put(&session, "/camera", &*message);
                count_log(bench, reason) > 0
            });
        }
    }
    assert!(fixture.bench.exported_in_place::<Image>("camera").is_none());
    assert_eq!(count_log(&fixture.bench, "/camera: it is neither"), 1);
    let pixels = [200, 100, 50].repeat(16 * 8);
    let file = Compression::Jpeg.encode((16, 8), Color::Rgb, &pixels).unwrap();
    let message = compressed(&file);
    fixture.until(|bench| {
        put(&session, "/camera", &*message);
        bench.exported_in_place::<Image>("camera").is_some()
    });
    let image = fixture.bench.exported_in_place::<Image>("camera").unwrap();
    assert_eq!((image.width, image.height, image.step), (16, 8, 48));
    assert_eq!(
        (image.encoding.as_str(), image.header.frame_id.as_str()),
        ("rgb8", "eye")
    );
    assert!(image.header.stamp.sec < 3600, "the application's time");
    assert!(image.data.iter().zip(&pixels).all(|(a, b)| a.abs_diff(*b) < 6));
}

#[test]
fn only_pictures_are_compressed_and_in_a_known_way() {
    let refused = |entry: Entry, words: &str| {
        let mut bench = Bench::<Topics>::with_lists(&[entry]);
        let problems = bench.inspect().unwrap();
        assert!(
            problems.len() == 1 && problems[0].words.contains(words),
            "{problems:?}"
        );
    };
    let publish = |settings| Entry::new::<Image>("publish", "image").settings(&settings);
    refused(publish(publication("gif")), "expected \"jpeg\" or \"png\"");
    let with_info = Publication {
        field_of_view: 1.0,
        ..publication("png")
    };
    refused(publish(with_info), "without `compressed`");
    let scan = Entry::new::<LaserScan>("publish", "scan").settings(&publication("png"));
    refused(scan, "`compressed` belongs to pictures");
    let scan = Entry::new::<LaserScan>("subscribe", "scan").settings(&SUBSCRIPTION);
    refused(scan, "`compressed` belongs to pictures");
}
