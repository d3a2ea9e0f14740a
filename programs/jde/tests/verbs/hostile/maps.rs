//! Maps and pictures.

use std::io::Write as _;
use std::path::Path;

use flate2::write::ZlibEncoder;
use flate2::{Compress, Compression, Crc, FlushCompress};

use super::files::{add_packed, write};

/// Cells of a side of a chess-board: as many as a map may have.
const SIDE: usize = 10_000;

/// Writes the file of a map with this image.
pub(super) fn map(folder: &Path, image: &str) {
    let text = format!(
        "image: {image}\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    );
    write(folder, "m.yaml", text);
}

/// Writes a world with a map, and an application with a robot in it.
pub(super) fn mapped(folder: &Path) {
    write(folder, "w.toml", "map = \"m.yaml\"\n");
    super::worlds::simulated(folder);
}

/// Fields of a chess-board, one pixel each. A picture at the limit of pixels would take nearly as long as an inspection may,
/// in a build without optimisation.
pub(super) fn chess_png(folder: &Path) {
    map(folder, "m.png");
    let side = SIDE / 2;
    // Rows begin with the way in which they are packed.
    let rows = [0xaa, 0x55].map(|field: u8| [vec![0], vec![field; side / 8]].concat());
    let mut packing = ZlibEncoder::new(Vec::new(), Compression::best());
    for _ in 0..side / 2 {
        packing.write_all(&rows.concat()).expect("it is written");
    }
    let pixels = packing.finish().expect("it is written");
    write(folder, "m.png", png([side as u32; 2], &pixels));
}

/// The same with a smaller side, in a Netpbm file that is packed.
pub(super) fn chess_pgm(folder: &Path) {
    map(folder, "m.pgm");
    let side = SIDE / 4;
    let fields: Vec<u8> = (0..=side).map(|column| [0, 254][column % 2]).collect();
    let rows = [&fields[..side], &fields[1..]].concat();
    add_packed(folder, "m.pgm", format!("P5\n{side} {side}\n255\n").as_bytes(), 1);
    add_packed(folder, "m.pgm", &rows, side / 2);
}

/// A picture that states 65,000 pixels on each side.
pub(super) fn stated(folder: &Path, name: &str) {
    map(folder, name);
    let side = 65_000_u32;
    let [high, low] = [0xfd, 0xe8];
    let bytes = match name.split_once('.').map(|(_, extension)| extension) {
        Some("png") => png([side; 2], &[]),
        Some("jpg") => {
            let frame = [
                0xff, 0xd8, 0xff, 0xc0, 0, 11, 8, high, low, high, low, 1, 1, 0x11, 0,
            ];
            let scan = [0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0, 0, 0xff, 0xd9];
            [&frame[..], &scan[..]].concat()
        }
        Some("bmp") => {
            let size = side.to_le_bytes();
            let head = [
                &b"BM"[..],
                &[0; 8],
                &54_u32.to_le_bytes(),
                &40_u32.to_le_bytes(),
                &size,
                &size,
            ];
            [&head.concat()[..], &[1, 0, 24, 0], &[0; 24]].concat()
        }
        Some("gif") => [
            &b"GIF89a"[..],
            &[
                low, high, low, high, 0, 0, 0, 0x2c, 0, 0, 0, 0, low, high, low, high, 0,
            ],
        ]
        .concat(),
        Some("tif") => tiff(side),
        Some("ppm") => format!("P6\n{side} {side}\n255\n").into_bytes(),
        Some("pbm") => format!("P1\n{side} {side}\n1").into_bytes(),
        _ => format!("P2\n{side} {side}\n255\n0").into_bytes(),
    };
    write(folder, name, bytes);
}

/// A PNG with a text that unpacks to gigabytes, before its pixels.
pub(super) fn packed_text(folder: &Path) {
    map(folder, "m.png");
    let mut packing = Compress::new(Compression::best(), true);
    let mut block = || {
        let mut packed = Vec::with_capacity(1 << 16);
        let done = packing.compress_vec(&[b' '; 1 << 20], &mut packed, FlushCompress::Full);
        done.map(|_| packed).expect("it is packed")
    };
    // After a full flush each block is packed alike.
    let text = [&b"name\0\0"[..], &block(), &block().repeat(2000)].concat();
    let whole = png([1, 1], &[]);
    // Behind the size.
    let (head, rest) = whole.split_at(33);
    write(folder, "m.png", [head, &part(b"zTXt", &text), rest].concat());
}

/// A map of MovingAI that states a size.
pub(super) fn moving_ai(folder: &Path, [width, height]: [u64; 2]) {
    let text = format!(
        "type octile\nheight {height}\nwidth {width}\nmap\n{}",
        "..\n".repeat(9)
    );
    write(folder, "m.map", text);
}

/// A map of MovingAI that states a hundred million rows and has some of them, packed.
pub(super) fn moving_ai_rows(folder: &Path) {
    let head = "type octile\nheight 99999999\nwidth 1\nmap\n";
    add_packed(folder, "m.map", head.as_bytes(), 1);
    add_packed(folder, "m.map", &b".\n".repeat(1 << 19), 4);
}

/// A PNG of bits with these packed pixels.
fn png([width, height]: [u32; 2], pixels: &[u8]) -> Vec<u8> {
    let size = [&width.to_be_bytes()[..], &height.to_be_bytes(), &[1, 0, 0, 0, 0]].concat();
    let parts = [part(b"IHDR", &size), part(b"IDAT", pixels), part(b"IEND", &[])];
    [&b"\x89PNG\r\n\x1a\n"[..], &parts.concat()].concat()
}

fn part(name: &[u8; 4], content: &[u8]) -> Vec<u8> {
    let named = [name, content].concat();
    let mut sum = Crc::new();
    sum.update(&named);
    [
        &(content.len() as u32).to_be_bytes()[..],
        &named,
        &sum.sum().to_be_bytes(),
    ]
    .concat()
}

fn tiff(side: u32) -> Vec<u8> {
    // Width, height, bits, packing, colours, place, samples, rows and bytes of a strip.
    let entries = [
        (256, side),
        (257, side),
        (258, 8),
        (259, 1),
        (262, 1),
        (273, 8),
        (277, 1),
        (278, side),
        (279, 8),
    ];
    let entries = entries.map(|(tag, value): (u16, u32)| {
        [&tag.to_le_bytes()[..], &[4, 0, 1, 0, 0, 0], &value.to_le_bytes()].concat()
    });
    [&b"II*\0\x08\0\0\0\x09\0"[..], &entries.concat(), &[0; 4]].concat()
}
