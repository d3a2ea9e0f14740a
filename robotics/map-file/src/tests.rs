//! Maps as map servers write them and as people change them: formats of images, forms of numbers, and limits.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, GrayAlphaImage, GrayImage, ImageFormat, RgbImage, RgbaImage};

use super::MapCell::{Free, Occupied, Unknown};
use super::*;

const YAML: &str = "image: m\nresolution: 0.05\norigin: [0, 0, 0]\n";

/// Reads a map with this YAML file and this image `m`.
fn load(yaml: impl AsRef<[u8]>, image: &[u8]) -> Result<MapFile, String> {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("m.yaml"), yaml).expect("it is written");
    fs::write(folder.path().join("m"), image).expect("it is written");
    let path = folder.path().to_str().expect("UTF-8").to_owned();
    MapFile::load(&folder.path().join("m.yaml")).map_err(|faults| faults.to_string().replace(&path, ""))
}

fn cells(yaml: &str, image: &[u8]) -> Vec<MapCell> {
    load(yaml, image).expect("a map").cells
}

fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, format).expect("it is written");
    bytes.into_inner()
}

fn png(color: png::ColorType, depth: png::BitDepth, (width, height): (u32, u32), samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if color == png::ColorType::Indexed {
        encoder.set_palette(vec![0, 0, 0, 205, 205, 205, 254, 254, 254]);
        encoder.set_trns(vec![255, 255, 0]);
    }
    let mut writer = encoder.write_header().expect("it is written");
    writer.write_image_data(samples).expect("it is written");
    writer.finish().expect("it is written");
    bytes
}

#[test]
fn each_format_of_images_gives_the_same_cells() {
    let shades = [254, 0, 205, 254, 254, 0];
    let gray = || GrayImage::from_raw(3, 2, shades.to_vec()).expect("six pixels");
    let color = || {
        RgbImage::from_raw(3, 2, shades.iter().flat_map(|shade| [*shade; 3]).collect()).expect("six pixels")
    };
    let opaque = RgbaImage::from_fn(3, 2, |x, y| {
        let shade = shades[(y * 3 + x) as usize];
        image::Rgba([shade, shade, shade, 255])
    });
    let text = |magic: &str, values: &dyn Fn(u8) -> String| {
        let values: Vec<_> = shades.iter().map(|shade| values(*shade)).collect();
        format!("{magic} # by hand\n3 2 255\n{}\n", values.join("\n")).into_bytes()
    };
    let raw = |magic: &str, copies| {
        let header = format!("{magic}\n3 2\n255\n").into_bytes();
        [
            header,
            shades.iter().flat_map(|shade| vec![*shade; copies]).collect(),
        ]
        .concat()
    };
    let wide: Vec<u8> = shades.iter().flat_map(|shade| [*shade; 2]).collect();
    let files = [
        encoded(gray(), ImageFormat::Bmp),
        encoded(color(), ImageFormat::Bmp),
        encoded(opaque.clone(), ImageFormat::Gif),
        encoded(gray(), ImageFormat::Tiff),
        encoded(opaque, ImageFormat::Tiff),
        png(png::ColorType::Grayscale, png::BitDepth::Sixteen, (3, 2), &wide),
        text("P2", &|shade| shade.to_string()),
        text("P3", &|shade| format!("{shade} {shade} {shade}")),
        raw("P5", 1),
        raw("P6", 3),
    ];
    for file in files {
        assert_eq!(
            cells(YAML, &file),
            [Free, Free, Occupied, Free, Occupied, Unknown]
        );
    }
    // A JPEG has losses, and here none that matter.
    let blocks = GrayImage::from_fn(16, 8, |x, _| image::Luma([if x < 8 { 0 } else { 254 }]));
    let jpeg = cells(YAML, &encoded(blocks, ImageFormat::Jpeg));
    assert_eq!((jpeg[0], jpeg[15]), (Occupied, Free));
}

#[test]
fn bits_are_black_where_they_are_1() {
    for file in [&b"P1\n9 1\n1000000 0\n#\n1\n"[..], b"P4 9 1\n\x80\x80"] {
        let cells = cells(YAML, file);
        assert_eq!(
            (cells.len(), cells[0], cells[7], cells[8]),
            (9, Occupied, Free, Occupied)
        );
    }
}

#[test]
fn transparent_pixels_are_unknown() {
    let rgba = RgbaImage::from_raw(
        2,
        2,
        vec![0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255, 254, 255, 255, 255, 255],
    );
    let file = encoded(rgba.clone().expect("four pixels"), ImageFormat::Tiff);
    assert_eq!(cells(YAML, &file), [Unknown, Free, Unknown, Occupied]);
    let gray = GrayAlphaImage::from_raw(2, 1, vec![0, 255, 0, 7]).expect("two pixels");
    let samples = gray.into_raw();
    let file = png(
        png::ColorType::GrayscaleAlpha,
        png::BitDepth::Eight,
        (2, 1),
        &samples,
    );
    assert_eq!(cells(YAML, &file), [Occupied, Unknown]);
    assert_eq!(cells(&format!("{YAML}mode: raw"), &file), [Free, Free]);
    let file = png(
        png::ColorType::Indexed,
        png::BitDepth::Two,
        (3, 1),
        &[0b_00_01_10_00],
    );
    assert_eq!(cells(YAML, &file), [Occupied, Unknown, Unknown]);
}

/// The shades are those of GraphicsMagick 1.3.40 for these colours.
#[test]
fn a_colour_is_as_bright_as_it_looks() {
    for (color, shade) in [
        ([255, 0, 0], 76),
        ([0, 255, 0], 149),
        ([0, 0, 255], 29),
        ([255, 255, 0], 225),
        ([200, 100, 50], 124),
    ] {
        assert_eq!(Shade::Luminance.of(color), shade, "{color:?}");
    }
    assert_eq!(Shade::Red.of([1, 2, 3]), 1);
}

#[test]
fn a_number_may_be_quoted_and_a_flag_may_be_a_word() {
    let image = b"P5 2 1 255\n\x00\xfe";
    let quoted = "\u{feff}%YAML 1.1\n---\nimage: 'm'\nresolution: \"0.050000\" # m\norigin:\n- '-1.5'\n- \"2\"\n- 0.\n\
        occupied_thresh: '0.65'\nfree_thresh: \"0.196\"\nmode: Trinary\n";
    let map = load(quoted, image).expect("a map");
    assert_eq!((map.resolution, map.origin), (0.05, [-1.5, 2.0, 0.0]));
    for (flag, cells) in [
        ("0 no No off false FALSE n '0' \"False\"", [Occupied, Free]),
        ("1 yes YES on true True y '1' 2", [Free, Occupied]),
    ] {
        for flag in flag.split(' ') {
            let yaml = format!("{YAML}negate: {flag}\n");
            assert_eq!(self::cells(&yaml, image), cells, "{flag}");
        }
    }
    for flag in ["tRUE", "maybe", "0.0", "[0]", "''"] {
        let error = load(format!("{YAML}negate: {flag}\n"), image).expect_err(flag);
        assert!(error.starts_with("/m.yaml:4:9: `negate` is no flag"), "{error}");
    }
}

#[test]
fn each_kind_of_fault_is_shown_at_its_place() {
    for (yaml, expected) in [
        (
            "image: m\nresolution: 5 cm\norigin: [0, 0, 0]",
            "/m.yaml:2:13: `resolution` is not a number: expected more than 0 m\n    2 | resolution: 5 cm\n      |             ^^^^",
        ),
        (
            "image: m\nresolution: -0.05\norigin: [0, 0, 0]",
            "/m.yaml:2:13: `resolution` is -0.05: expected more than 0 m\n    2 | resolution: -0.05\n      |             ^^^^^",
        ),
        (
            "# Größe\nimage: m\nresolution: 1\norigin: [0, 0]",
            "/m.yaml:4:9: `origin` is not [x, y, yaw] in metres and radians\n    4 | origin: [0, 0]\n      |         ^^^^^^",
        ),
        (
            "image: m\nresoluton: 1\norigin: [0, 0, 0]",
            "/m.yaml: `resolution` is missing\n    help: is `resoluton` meant for it?",
        ),
        (
            "image: m\nresolution: 1\norigin: [0, 0, 0]\nmode: colour",
            "/m.yaml:4:7: `mode` is none of `trinary`, `scale` and `raw`\n    4 | mode: colour\n      |       ^^^^^^",
        ),
        (
            "image: m\norigin: [0, 0",
            "/m.yaml:2:14: this is not YAML: while parsing a flow sequence, expected ',' or ']'\n    2 | origin: [0, 0\n      |              ^",
        ),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("m"), b"P5 1 1 255\n\0").expect("it is written");
        let faults = MapFile::parse(&folder.path().join("m.yaml"), yaml).expect_err("a fault");
        let shown = format!("{faults:#}").replace(folder.path().to_str().expect("UTF-8"), "");
        assert_eq!(shown, expected, "{yaml}");
    }
}

#[test]
fn what_no_map_server_reads_is_named() {
    let yaml = format!("{YAML}resolution: 7\nfloor: {{ level: [1] }}\n? [a]\n: b\n");
    let map = load(yaml, b"P5 1 1 255\n\0").expect("a map");
    assert_eq!(map.resolution, 0.05);
    let lines: Vec<_> = map.left_out.lines().collect();
    assert_eq!(
        lines,
        [
            "the key `?` is left out: no map server reads it (line 7)",
            "the key `floor` is left out: no map server reads it (line 5)",
            "the key `resolution` is left out: it is stated twice, and the first one counts (line 4)",
        ]
    );
}

#[test]
fn an_image_may_be_packed_and_anywhere() {
    use std::io::Write;
    let folder = tempfile::tempdir().expect("a folder");
    let image = folder.path().join("m.pgm.gz");
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(b"P5 1 1 255\n\0").expect("it is packed");
    fs::write(&image, packed.finish().expect("it is packed")).expect("it is written");
    let yaml = format!("image: {}\nresolution: 1\norigin: [0, 0, 0]\n", image.display());
    let map = MapFile::parse(Path::new("/elsewhere/m.yaml"), &yaml).expect("a map");
    assert_eq!(map.cells, [Occupied]);
}

#[test]
fn an_image_that_is_not_found_is_searched_beside_the_yaml_file() {
    let yaml = |image: &str| format!("image: {image}\nresolution: 1\norigin: [0, 0, 0]\n");
    let error = load(yaml("/home/other/maps/m"), b"P5 1 1 255\n\0").expect_err("another computer's path");
    assert!(
        error.starts_with("/home/other/maps/m: cannot read the image: "),
        "{error}"
    );
    assert!(
        error.ends_with("\n    help: `image: m` is the one beside the YAML file"),
        "{error}"
    );
    let error = load(yaml("~/m"), b"P5 1 1 255\n\0").expect_err("no home");
    assert!(error.contains("m.yaml:1:8: `image` begins with `~`"), "{error}");
}

#[test]
fn a_file_of_another_kind_is_named_as_what_it_is() {
    for (bytes, expected) in [
        (
            &b"name = \"room\"\nmap = \"m.yaml\"\n"[..],
            "it is a TOML file, such as a world, and no ROS map: give the YAML file that its `map` names",
        ),
        (
            b"P5 1 1 255\n\xff",
            "it is a picture, and no ROS map: a picture states no lengths",
        ),
        (b"<sdf/>", "it is a world or a model in SDF, and no ROS map"),
        (
            b"\x89MCAP0\r\n\xff",
            "it is a recording or a log of a robot, and no ROS map",
        ),
    ] {
        let error = load(bytes, b"").expect_err("it is not a map");
        assert!(error.contains(expected), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

#[test]
fn half_an_image_is_refused() {
    let blocks = GrayImage::from_fn(64, 64, |x, y| image::Luma([(x * y) as u8]));
    for (format, expected) in [
        (ImageFormat::Jpeg, "half a JPEG"),
        (ImageFormat::Bmp, "no valid BMP"),
        (ImageFormat::Tiff, "no valid TIFF"),
        (ImageFormat::Gif, "no valid GIF"),
    ] {
        let bytes = encoded(DynamicImage::from(blocks.clone()).into_rgba8(), format);
        let error = load(YAML, &bytes[..bytes.len() / 2]).expect_err("half");
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_small_file_that_states_a_large_image_is_refused() {
    let mut bmp = encoded(GrayImage::new(1, 1), ImageFormat::Bmp);
    bmp[18..26].copy_from_slice(&[0, 0, 1, 0, 0, 0, 1, 0]);
    let mut gif = encoded(RgbaImage::new(1, 1), ImageFormat::Gif);
    gif[6..10].copy_from_slice(&[0xff; 4]);
    let mut png = Vec::new();
    let writer = png::Encoder::new(&mut png, 20_000, 20_000).write_header();
    (writer.and_then(|mut writer| writer.write_chunk(png::chunk::IDAT, &[0]))).expect("it is written");
    for file in [
        bmp,
        gif,
        png,
        b"P4 20000 20000\n".to_vec(),
        b"P1 1048577 1\n".to_vec(),
    ] {
        let error = load(YAML, &file).expect_err("it is too large");
        assert!(error.starts_with("/m:") && error.lines().count() == 1, "{error}");
    }
}

#[test]
fn a_small_text_takes_little_work_and_memory() {
    let bomb = (1..30).fold("a0: &a0 [x]\n".to_owned(), |text, level| {
        let alias = format!("*a{}, ", level - 1).repeat(9);
        text + &format!("a{level}: &a{level} [{alias}]\n")
    });
    let map = load(YAML.to_owned() + &bomb, b"P5 1 1 255\n\0").expect("aliases are not followed");
    assert_eq!(map.left_out.count(), 30);
    let keys: String = (0..100_000).map(|key| format!("k{key}: 1\n")).collect();
    assert!(
        load(YAML.to_owned() + &keys, b"")
            .expect_err("many keys")
            .contains("more than 1000 keys")
    );
    let deep = format!("{YAML}deep: {}", "[".repeat(100_000));
    assert!(load(deep, b"").expect_err("deep").contains("/m.yaml:4:"));
}
