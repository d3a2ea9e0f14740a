//! Compiled expressions have the results of CEL's interpreter.

use jde_types::{Flag, LaserScan, Seq, Value as _};
use proptest::prelude::*;

use super::*;

fn names() -> Names {
    let types = [
        ("a.bool", Flag::describe()),
        ("a.int", i64::describe()),
        ("a.uint", u64::describe()),
        ("a.double", f64::describe()),
        ("a.ints", <[i16; 3]>::describe()),
        ("a.scan", LaserScan::describe()),
    ];
    let variables = types.map(|(name, value_type)| (name.to_owned(), Arc::new(value_type)));
    Names {
        variables: BTreeMap::from(variables),
        ..Names::default()
    }
}

/// Random expressions of each kind.
#[derive(Clone)]
struct Texts {
    bools: BoxedStrategy<String>,
    ints: BoxedStrategy<String>,
    uints: BoxedStrategy<String>,
    doubles: BoxedStrategy<String>,
}

/// Returns expressions of the form, in which each `#` is one of the parts.
fn form(form: &'static str, parts: &[&BoxedStrategy<String>]) -> BoxedStrategy<String> {
    let parts: Vec<_> = parts.iter().copied().cloned().collect();
    let fill = move |parts: Vec<String>| {
        let parts = parts.iter();
        parts.fold(form.to_owned(), |text, part| text.replacen('#', part, 1))
    };
    parts.prop_map(fill).boxed()
}

fn one_of(texts: &[&str]) -> BoxedStrategy<String> {
    let texts: Vec<_> = texts.iter().map(|text| (*text).to_owned()).collect();
    prop::sample::select(texts).boxed()
}

fn leaves() -> Texts {
    Texts {
        bools: one_of(&["a.bool", "a.bool", "true", "false"]),
        ints: one_of(&[
            "a.int",
            "a.int",
            "0",
            "2",
            "-3",
            "9223372036854775807",
            "(-9223372036854775808)",
        ]),
        uints: one_of(&["a.uint", "a.uint", "0u", "2u", "18446744073709551615u"]),
        doubles: one_of(&[
            "a.double",
            "a.double",
            "a.scan.range_max",
            "0.0",
            "-1.5",
            "2.0",
            "1e308",
        ]),
    }
}

/// Adds a level of operators and functions to the expressions.
fn nested(inner: &Texts) -> Texts {
    let Texts {
        bools,
        ints,
        uints,
        doubles,
    } = inner;
    let comparison = &one_of(&["<", "<=", ">", ">=", "==", "!="]);
    let arithmetic = &one_of(&["+", "-", "*", "/", "%"]);
    let logic = &one_of(&["&&", "||"]);
    let any_number = &prop_oneof![ints.clone(), uints.clone(), doubles.clone()].boxed();
    let list = &one_of(&["a.ints.data", "a.scan.ranges"]);
    let fold = &one_of(&["exists", "all", "exists_one"]);
    let extreme = &one_of(&["math.least", "math.greatest"]);
    let index = &prop_oneof![ints.clone(), uints.clone(), one_of(&["0", "1", "2u"])].boxed();
    let numeric = |kind: &BoxedStrategy<String>| {
        prop_oneof![
            kind.clone(),
            form("(# # #)", &[kind, arithmetic, kind]),
            form("(# ? # : #)", &[bools, kind, kind]),
            form("math.abs(#)", &[kind]),
            form("#(#, #)", &[extreme, kind, kind]),
        ]
    };
    Texts {
        bools: prop_oneof![
            bools.clone(),
            form("(# # #)", &[bools, logic, bools]),
            form("(# # #)", &[bools, comparison, bools]),
            form("!#", &[bools]),
            form("(# ? # : #)", &[bools, bools, bools]),
            form("(# # #)", &[any_number, comparison, any_number]),
            form("#.#(x, x # #)", &[list, fold, comparison, any_number]),
            form("#.#(x, #)", &[list, fold, bools]),
            form("#.#(x, a.ints.data.#(y, y # x))", &[list, fold, fold, comparison]),
        ]
        .boxed(),
        ints: prop_oneof![
            3 => numeric(ints),
            1 => form("(-#)", &[ints]),
            1 => form("size(#)", &[list]),
            1 => form("a.ints.data[#]", &[index]),
            1 => form("#(a.ints.data)", &[extreme]),
        ]
        .boxed(),
        uints: numeric(uints).boxed(),
        doubles: prop_oneof![
            3 => numeric(doubles),
            1 => form("(-#)", &[doubles]),
            1 => form("double(#)", &[any_number]),
            1 => form("math.sqrt(#)", &[any_number]),
            1 => form("a.scan.ranges[#]", &[index]),
            1 => form("#(a.scan.ranges)", &[extreme]),
        ]
        .boxed(),
    }
}

/// An expression of any kind.
fn text() -> impl Strategy<Value = String> {
    let texts = (0..3).fold(leaves(), |texts, _| nested(&texts));
    prop_oneof![3 => texts.bools, 1 => texts.ints, 1 => texts.uints, 1 => texts.doubles]
}

fn double() -> impl Strategy<Value = f64> {
    prop_oneof![
        prop::sample::select(vec![
            0.0,
            -0.0,
            2.0,
            f64::NAN,
            f64::INFINITY,
            9_007_199_254_740_993.0
        ]),
        any::<f64>(),
    ]
}

/// The bytes of a value of each input, some of which are missing.
fn values() -> impl Strategy<Value = BTreeMap<&'static str, Vec<u8>>> {
    let missing = prop::collection::vec(prop::bool::weighted(0.1), 6);
    let int = prop_oneof![-3_i64..3, any::<i64>()];
    let uint = prop_oneof![0_u64..3, any::<u64>()];
    let ranges = prop::collection::vec(double().prop_map(|range| range as f32), 0..4);
    (
        missing,
        any::<bool>(),
        int,
        uint,
        double(),
        any::<[i16; 3]>(),
        ranges,
    )
        .prop_map(|(missing, flag, int, uint, double, ints, ranges)| {
            let scan = LaserScan {
                range_max: double as f32,
                ranges: Seq::from_slice(&ranges).expect("there are few"),
                ..LaserScan::default()
            };
            let values = [
                ("a.bool", Flag::from(flag).as_bytes().to_vec()),
                ("a.int", int.as_bytes().to_vec()),
                ("a.uint", uint.as_bytes().to_vec()),
                ("a.double", double.as_bytes().to_vec()),
                ("a.ints", ints.as_bytes().to_vec()),
                ("a.scan", scan.as_bytes().to_vec()),
            ];
            let known = values.into_iter().zip(missing).filter(|(_, missing)| !missing);
            known.map(|(value, _)| value).collect()
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, ..ProptestConfig::default() })]

    #[test]
    fn a_compiled_expression_has_the_result_of_the_interpreter(text in text(), values in values()) {
        let names = names();
        let mut expression = match Expression::new(&text, &names) {
            Ok(expression) => expression,
            Err(error) => {
                prop_assert!(error.to_string().contains("it names no variable"), "{error}");
                return Ok(());
            }
        };
        let inputs: Vec<_> = expression.inputs().map(str::to_owned).collect();
        for (place, input) in inputs.iter().enumerate() {
            expression.set(place, values.get(input.as_str()).map(Vec::as_slice));
        }
        prop_assert!(matches!(expression.evaluator, Evaluator::Compiled(_)), "{} is not compiled", text);
        let program = compile(&text).expect("it was parsed before");
        let interpreted = interpret(&program, &expression.inputs);
        let compiled = expression.evaluate();
        let are_nan = [interpreted, compiled].iter().all(|number| {
            matches!(number, Some(Number::Double(value)) if value.is_nan())
        });
        prop_assert!(are_nan || interpreted == compiled, "{interpreted:?}, {compiled:?}: {text}");
    }
}

#[test]
fn what_is_not_over_numbers_is_interpreted() {
    for text in [
        "a.scan.header.frame_id == 'map'",
        "a.ints.data.map(x, x * 2)[0] > 1",
        "size([a.int]) == 1",
    ] {
        let expression = Expression::new(text, &names()).unwrap();
        assert!(
            matches!(expression.evaluator, Evaluator::Interpreted(_)),
            "{text}"
        );
    }
}
