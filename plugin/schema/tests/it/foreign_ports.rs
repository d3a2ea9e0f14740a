//! A port belongs to the type that declares it. In a call of another type, its number would mean another
//! port, so it is refused.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;

/// Has ports with large values where the other schema has ports with small ones.
#[derive(Describe)]
#[schema(motor, period = "1s")]
struct Wide {
    #[import(optional)]
    read: Import<Route>,
    #[actuator(optional)]
    base: Actuator<Route>,
    #[modulation(default = 0.5)]
    gain: Modulation<f64>,
}

impl Schema for Wide {
    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }
}

/// Uses the ports of the other schema in its own calls.
#[derive(Describe)]
#[schema(motor, period = "1s")]
struct Narrow {
    #[import(optional)]
    read: Import<u8>,
    #[actuator(optional)]
    base: Actuator<u8>,
    #[modulation(default = 2.0)]
    gain: Modulation<f64>,
    iterations: u8,
}

impl Schema for Narrow {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok((self.gain.get(cx) > 0.0 && self.read.get(cx).is_none()).into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let other = Bench::<Wide>::new();
        let wide = other.schema();
        self.iterations += 1;
        match self.iterations {
            1 => wide.base.command(cx, Route::EMPTY).accepted(),
            2 => wide.read.get(cx).is_some(),
            3 => wide.gain.get(cx) > 0.0,
            _ => self.base.command(cx, 7).accepted(),
        };
        Ok(())
    }
}

#[test]
fn a_call_that_uses_a_port_of_another_type_fails() {
    let mut bench = Bench::<Narrow>::new();
    assert!(bench.check().expect("no fault").ready);
    for port in ["base", "read", "gain"] {
        let failure = bench
            .iterate()
            .expect_err("the port is of another type")
            .to_string();
        let expected = format!("`{port}` is a port of another schema");
        assert!(failure.contains(&expected), "{failure}");
        assert_eq!(bench.commanded::<u8>("base"), None);
    }
    bench.iterate().expect("its own port");
    assert_eq!(bench.commanded::<u8>("base"), Some(7));
}
