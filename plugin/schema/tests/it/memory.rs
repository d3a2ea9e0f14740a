//! The memory that one instance of a schema saves and another restores.

use jde_schema::bench::{Bench, Remembered};
use jde_schema::prelude::*;

/// Saves an entry of every kind.
#[derive(Describe)]
#[schema(perceptive, period = "100ms")]
struct Reader {
    #[export]
    read: Export<u32>,
    pages: u32,
    places: Vec<Pose2D>,
    name: String,
    violation: Violation,
}

/// The rule that a save or a restore breaks.
#[derive(Default, Clone, Copy, PartialEq)]
enum Violation {
    #[default]
    Nothing,
    Writing,
    Panicking,
}

impl Schema for Reader {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.pages += 1;
        self.places.push(Pose2D::new(f64::from(self.pages), 0.0, 0.0));
        self.name = format!("page {}", self.pages);
        if self.pages == 9 {
            self.violation = Violation::Writing;
        }
        if self.pages == 10 {
            self.violation = Violation::Panicking;
        }
        self.read.write(cx, self.pages);
        Ok(())
    }
}

impl Memory for Reader {
    const VERSION: u32 = 2;

    fn save(&self, _: &Context, saving: &mut Saving) {
        assert!(self.violation != Violation::Panicking, "save failed");
        saving.put(&self.pages);
        saving.put_all(&self.places);
        saving.put_text(&self.name);
    }

    fn restore(&mut self, cx: &Context, saved: &mut Saved) -> Result {
        self.pages = saved.take()?;
        self.places = saved.take_all()?;
        if saved.version() >= 2 {
            self.name = saved.take_text()?.to_owned();
        }
        if self.pages >= 9 {
            self.read.write(cx, 0);
        }
        Ok(())
    }
}

/// Saves another type as the first entry.
#[derive(Describe)]
#[schema(perceptive, period = "100ms")]
struct Other {
    #[export]
    read: Export<u32>,
}

impl Schema for Other {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.read.write(cx, 0);
        Ok(())
    }
}

impl Memory for Other {
    fn save(&self, _: &Context, saving: &mut Saving) {
        saving.put(&7.0_f64);
    }

    fn restore(&mut self, _: &Context, _: &mut Saved) -> Result {
        Ok(())
    }
}

fn reader(pages: u32) -> Bench<Reader> {
    let mut bench = Bench::new();
    for _ in 0..pages {
        bench.iterate().expect("no fault");
    }
    bench
}

#[test]
fn an_instance_restores_what_another_saved() {
    let saved = reader(3).save().expect("it saves");
    assert_eq!(saved.version, 2);
    let mut next = reader(0);
    next.restore(&saved).expect("it restores");
    let Reader {
        pages, places, name, ..
    } = next.schema();
    assert_eq!((*pages, places.len(), name.as_str()), (3, 3, "page 3"));
    assert_eq!(places[2], Pose2D::new(3.0, 0.0, 0.0));
}

#[test]
fn a_memory_of_an_older_version_restores_the_entries_that_it_has() {
    let mut saved = reader(2).save().expect("it saves");
    saved.version = 1;
    let mut next = reader(0);
    next.restore(&saved).expect("it restores");
    assert_eq!((next.schema().pages, next.schema().name.as_str()), (2, ""));
}

#[test]
fn a_memory_with_a_wrong_or_missing_entry_is_refused() {
    let saved = Bench::<Other>::new().save().expect("it saves");
    let refused = reader(0).restore(&saved).expect_err("the entry is a Float64");
    assert_eq!(
        refused.reason,
        "a std_msgs/msg/UInt32 was to come, and a std_msgs/msg/Float64 was saved in version 1"
    );
    let empty = Remembered {
        version: 1,
        bytes: Vec::new(),
    };
    let refused = reader(0).restore(&empty).expect_err("the memory is empty");
    assert!(refused.reason.contains("nothing more was saved"), "{refused}");
    let complete = reader(2).save().expect("it saves");
    for end in 0..complete.bytes.len() {
        let truncated = Remembered {
            version: 2,
            bytes: complete.bytes[..end].to_vec(),
        };
        reader(0)
            .restore(&truncated)
            .expect_err("the memory is truncated");
    }
}

#[test]
fn a_write_in_restore_is_refused_and_a_panic_in_save_is_reported() {
    let saved = reader(9).save().expect("it saves");
    let refused = reader(0).restore(&saved).expect_err("restore writes");
    assert_eq!(
        refused.reason,
        "it tried to write in restore, which changes nothing"
    );
    let failed = reader(10).save().expect_err("save panics");
    assert!(
        failed.panicked() && failed.reason.contains("save failed"),
        "{failed}"
    );
}

#[test]
fn a_schema_has_only_the_abilities_that_it_implements() {
    let bench = Bench::<Reader>::new();
    assert!(!bench.description().arbitrates);
    assert!(Reader::TABLE.ability.is_some());
    assert!(Reader::PANEL.is_none() && Reader::STATE.is_some());
}
