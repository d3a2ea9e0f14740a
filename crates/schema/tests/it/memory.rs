//! The memory of a schema, from one instance to the next.

use jde_schema::bench::{Bench, Remembered};
use jde_schema::prelude::*;

/// Saves an entry of every kind.
#[derive(Describe)]
#[schema(perceptive, period = "100ms")]
struct Scholar {
    #[export]
    read: Export<u32>,
    pages: u32,
    places: Vec<Pose2D>,
    name: String,
    tries: Tries,
}

/// What a save or a restore does against the rules.
#[derive(Default, Clone, Copy, PartialEq)]
enum Tries {
    #[default]
    Nothing,
    Writing,
    Panicking,
}

impl Schema for Scholar {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.pages += 1;
        self.places.push(Pose2D::new(f64::from(self.pages), 0.0, 0.0));
        self.name = format!("page {}", self.pages);
        if self.pages == 9 {
            self.tries = Tries::Writing;
        }
        if self.pages == 10 {
            self.tries = Tries::Panicking;
        }
        self.read.write(cx, self.pages);
        Ok(())
    }
}

impl Memory for Scholar {
    const VERSION: u32 = 2;

    fn save(&self, _: &Context, saving: &mut Saving) {
        assert!(self.tries != Tries::Panicking, "it forgot");
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

fn scholar(pages: u32) -> Bench<Scholar> {
    let mut bench = Bench::new();
    for _ in 0..pages {
        bench.iterate().expect("it reads");
    }
    bench
}

#[test]
fn what_one_saved_the_next_takes_over() {
    let saved = scholar(3).save().expect("it saves");
    assert_eq!(saved.version, 2);
    let mut next = scholar(0);
    next.restore(&saved).expect("it restores");
    let Scholar {
        pages, places, name, ..
    } = next.schema();
    assert_eq!((*pages, places.len(), name.as_str()), (3, 3, "page 3"));
    assert_eq!(places[2], Pose2D::new(3.0, 0.0, 0.0));
}

#[test]
fn an_older_version_is_read_as_far_as_it_goes() {
    let mut saved = scholar(2).save().expect("it saves");
    saved.version = 1;
    let mut next = scholar(0);
    next.restore(&saved).expect("it restores");
    assert_eq!((next.schema().pages, next.schema().name.as_str()), (2, ""));
}

#[test]
fn what_does_not_fit_is_refused_in_words() {
    let saved = Bench::<Other>::new().save().expect("it saves");
    let refused = scholar(0).restore(&saved).expect_err("it is a Float64");
    assert_eq!(
        refused.reason,
        "a std_msgs/msg/UInt32 was to come, and a std_msgs/msg/Float64 was saved in version 1"
    );
    let nothing = Remembered {
        version: 1,
        bytes: Vec::new(),
    };
    let refused = scholar(0).restore(&nothing).expect_err("there is nothing");
    assert!(refused.reason.contains("nothing more was saved"), "{refused}");
    let whole = scholar(2).save().expect("it saves");
    for end in 0..whole.bytes.len() {
        let cut = Remembered {
            version: 2,
            bytes: whole.bytes[..end].to_vec(),
        };
        scholar(0).restore(&cut).expect_err("it is cut");
    }
}

#[test]
fn a_memory_is_handed_over_and_changes_nothing_else() {
    let mut nine = scholar(9);
    let saved = nine.save().expect("it saves");
    let refused = scholar(0).restore(&saved).expect_err("it writes");
    assert_eq!(
        refused.reason,
        "it tried to write in restore, which changes nothing"
    );
    let failed = scholar(10).save().expect_err("it panics");
    assert!(
        failed.panicked() && failed.reason.contains("it forgot"),
        "{failed}"
    );
}

#[test]
fn a_schema_has_the_abilities_it_was_given_and_no_other() {
    let described = Bench::<Scholar>::new();
    assert!(!described.description().arbitrates);
    assert!(Scholar::TABLE.ability.is_some());
    assert!(Scholar::PANEL.is_none() && Scholar::STATE.is_some());
}
