//! What reading and publishing cost without contention, beside a mutex in the same run: `cargo bench -p jde-board`.
//!
//! The middle one of the three times printed is the median. Claims about times live here, not in tests.

use std::hint::black_box;
use std::sync::{Arc, Mutex};

use criterion::{Criterion, criterion_group, criterion_main};
use jde_abi::describe::{Field, FieldKind, Form, Scalar, Type};
use jde_board::typed::{TypedReader, TypedWriter};
use jde_board::{Access, Board, Declaration, Variable};

/// Words of a velocity.
const SMALL: usize = 6;
/// Words of a 640 x 480 picture of three bytes a pixel.
const IMAGE: usize = 640 * 480 * 3 / 8;

fn variable(words: usize, kind: Scalar, access: Access) -> Arc<Variable> {
    let field = Field {
        name: "data".to_owned(),
        doc: String::new(),
        unit: String::new(),
        kind: FieldKind::Scalar(kind),
        form: Form::Array(words),
        offset: 0,
    };
    let value_type = Type {
        name: "bench/Words".to_owned(),
        doc: String::new(),
        bytes: words * 8,
        align: 8,
        fields: vec![field],
    };
    let declared = Board::new().declare(Declaration {
        owner: "bench".to_owned(),
        name: "value".to_owned(),
        doc: String::new(),
        unit: String::new(),
        value_type: Arc::new(value_type),
        access,
        initial: None,
        writers: 1,
        readers: 1,
    });
    declared.expect("a plain variable can be declared")
}

fn reads(bench: &mut Criterion) {
    let mut group = bench.benchmark_group("read 48 bytes");
    for (name, access) in [("ring", Access::Export), ("pinned", Access::Modulation)] {
        let small = variable(SMALL, Scalar::F64, access);
        let mut writer = TypedWriter::<[f64; SMALL]>::open(&small, 1, "w").expect("it fits");
        let mut reader = TypedReader::<[f64; SMALL]>::open(&small, "r").expect("it fits");
        writer.write([1.0; SMALL], 0, 0).expect("it is finite");
        group.bench_function(format!("{name}, in place"), |bench| {
            bench.iter(|| black_box(reader.borrow().map(|value| value[0] + value[SMALL - 1])));
        });
        group.bench_function(format!("{name}, a copy"), |bench| {
            bench.iter(|| black_box(reader.get()))
        });
    }
    let mutex = Mutex::new([1.0; SMALL]);
    group.bench_function("mutex", |bench| {
        bench.iter(|| black_box(*black_box(&mutex).lock().expect("not poisoned")))
    });
    group.finish();

    let mut group = bench.benchmark_group("read an image");
    let image = variable(IMAGE, Scalar::U64, Access::Export);
    let mut writer = image.writer(1, "w").expect("nobody writes it");
    let mut reader = image.reader("r");
    writer.loan().fill(1);
    writer.publish(0, 0).expect("an export is not refused");
    group.bench_function("pinned", |bench| {
        bench.iter(|| {
            black_box(reader.latch().map(|latched| latched.bytes[0]));
            reader.release();
        });
    });
    let mutex = Mutex::new(vec![1u8; IMAGE * 8]);
    group.bench_function("mutex", |bench| {
        bench.iter(|| black_box(mutex.lock().expect("not poisoned").clone()))
    });
    group.finish();
}

fn publishes(bench: &mut Criterion) {
    let mut group = bench.benchmark_group("publish 48 bytes");
    let validity = 500_000_000;
    for (name, access) in [
        ("ring", Access::Export),
        ("command", Access::Command { validity }),
    ] {
        let small = variable(SMALL, Scalar::F64, access);
        small.grant(1);
        let mut writer = TypedWriter::<[f64; SMALL]>::open(&small, 1, "w").expect("it fits");
        let mut time = 0;
        group.bench_function(name, |bench| {
            bench.iter(|| {
                time += 1;
                writer.write(black_box([1.0; SMALL]), time, time)
            });
        });
    }
    let mutex = Mutex::new([0.0; SMALL]);
    group.bench_function("mutex", |bench| {
        bench.iter(|| *mutex.lock().expect("not poisoned") = black_box([1.0; SMALL]));
    });
    group.finish();

    let image = variable(IMAGE, Scalar::U64, Access::Export);
    let mut writer = image.writer(1, "w").expect("nobody writes it");
    bench.bench_function("loan and publish an image", |bench| {
        bench.iter(|| {
            writer.loan()[0] = 1;
            writer.publish(0, 0)
        });
    });
    let command = variable(SMALL, Scalar::F64, Access::Command { validity });
    bench.bench_function("grant and withdraw", |bench| {
        bench.iter(|| {
            command.grant(1);
            command.withdraw(1);
        });
    });
}

criterion_group! {
    name = cells;
    config = Criterion::default().without_plots();
    targets = reads, publishes
}
criterion_main!(cells);
