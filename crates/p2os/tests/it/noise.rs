//! The corpus for fuzzing, mutations of it and noise, all through the checks of the fuzzers.

use crate::checks;

use std::fs;
use std::path::Path;

/// A random number generator that is the same in every run.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, below: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % below.max(1)
    }

    fn byte(&mut self) -> u8 {
        // Meaningful bytes occur more often than by chance.
        match self.roll(4) {
            0 => [0xFA, 0xFB, 0, 1, 2, 0x3B, 0x1B, 0x2B, 0x32, 0x60, 0xEF, 0xFF][self.roll(12)],
            _ => self.roll(256) as u8,
        }
    }

    fn noise(&mut self) -> Vec<u8> {
        (0..self.roll(400)).map(|_| self.byte()).collect()
    }

    fn mutated(&mut self, mut bytes: Vec<u8>) -> Vec<u8> {
        for _ in 0..=self.roll(6) {
            let place = self.roll(bytes.len());
            match self.roll(4) {
                0 if !bytes.is_empty() => bytes[place] = self.byte(),
                1 if !bytes.is_empty() => drop(bytes.remove(place)),
                2 => bytes.insert(place, self.byte()),
                _ => bytes.truncate(self.roll(bytes.len() + 1).max(bytes.len() / 2)),
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

fn hold(target: &str, check: fn(&[u8])) {
    let corpus = corpus(target);
    for bytes in &corpus {
        check(bytes);
    }
    let mut dice = Dice(0x9E37_79B9_7F4A_7C15);
    for _ in 0..10_000 {
        let from = corpus[dice.roll(corpus.len())].clone();
        check(&dice.mutated(from));
        check(&dice.noise());
    }
}

#[test]
fn no_stream_upsets_the_receiver() {
    hold("receiver", checks::receiver);
}

#[test]
fn no_payload_upsets_the_reader_of_commands() {
    hold("command", checks::command);
}

#[test]
fn no_payload_upsets_the_readers_of_what_robots_say() {
    hold("answer", checks::answer);
}

#[test]
fn no_robot_upsets_the_session_or_makes_it_move_what_nobody_wished_to_move() {
    hold("session", checks::session);
}

#[test]
fn no_stream_upsets_the_reader_of_the_cameras_frames() {
    hold("head", checks::head);
}
