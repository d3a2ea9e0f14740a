//! Runs the checks of the fuzzers on the fuzzing corpus, on mutations of it and on noise.

use crate::checks;

use std::fs;
use std::path::Path;

/// A random number generator that is the same in every run.
struct Generator(u64);

impl Generator {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % limit.max(1)
    }

    fn byte(&mut self) -> u8 {
        // Meaningful bytes occur more often than by chance.
        match self.below(4) {
            0 => [0xFA, 0xFB, 0, 1, 2, 0x3B, 0x1B, 0x2B, 0x32, 0x60, 0xEF, 0xFF][self.below(12)],
            _ => self.below(256) as u8,
        }
    }

    fn noise(&mut self) -> Vec<u8> {
        (0..self.below(400)).map(|_| self.byte()).collect()
    }

    fn mutated(&mut self, mut bytes: Vec<u8>) -> Vec<u8> {
        for _ in 0..=self.below(6) {
            let index = self.below(bytes.len());
            match self.below(4) {
                0 if !bytes.is_empty() => bytes[index] = self.byte(),
                1 if !bytes.is_empty() => drop(bytes.remove(index)),
                2 => bytes.insert(index, self.byte()),
                _ => bytes.truncate(self.below(bytes.len() + 1).max(bytes.len() / 2)),
            }
        }
        bytes
    }
}

fn corpus(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../fuzz/corpus")
        .join(target);
    let mut files: Vec<_> = fs::read_dir(folder)
        .expect("the corpus is part of the project")
        .map(|file| file.unwrap().path())
        .collect();
    files.sort();
    assert!(files.len() >= 4, "a corpus of {} files", files.len());
    files.iter().map(|file| fs::read(file).unwrap()).collect()
}

fn check_all(target: &str, check: fn(&[u8])) {
    let corpus = corpus(target);
    for bytes in &corpus {
        check(bytes);
    }
    let mut generator = Generator(0x9E37_79B9_7F4A_7C15);
    for _ in 0..10_000 {
        let base = corpus[generator.below(corpus.len())].clone();
        check(&generator.mutated(base));
        check(&generator.noise());
    }
}

#[test]
fn the_receiver_accepts_any_stream() {
    check_all("receiver", checks::receiver);
}

#[test]
fn the_decoder_of_commands_accepts_any_payload() {
    check_all("command", checks::command);
}

#[test]
fn the_decoders_of_replies_accept_any_payload() {
    check_all("answer", checks::answer);
}

#[test]
fn a_session_accepts_any_robot_and_moves_it_only_on_request() {
    check_all("session", checks::session);
}

#[test]
fn the_parser_of_camera_frames_accepts_any_stream() {
    check_all("head", checks::head);
}
