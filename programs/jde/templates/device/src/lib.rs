//! A driver for a thermometer on a serial line or TCP, and a schema that logs its temperature.

#[cfg(test)]
mod emulator;
mod session;

use jde_device::port::{Address, Backoff, Port};
use jde_device::{Device, inspect_port};
use jde_schema::prelude::*;

use session::Session;

/// A thermometer. The driver reconnects after each loss.
#[derive(Describe)]
#[schema(driver, period = "20ms")]
pub struct __Name__ {
    /// Address of the device: "serial:/dev/ttyUSB0@9600", or "tcp:HOST:PORT".
    #[modulation(default = "", fixed)]
    port: Modulation<Text<256>>,
    /// The temperature. It has no value while the thermometer does not reply.
    #[export(unit = "degC")]
    temperature: Export<f64>,
    /// Whether the thermometer is connected.
    #[export]
    connection: Export<Connection>,
    device: Option<Device<Session>>,
}

impl Schema for __Name__ {
    /// Called before the first iteration, and again after each sleep.
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        self.device = Some(Device::new(Port::new(self.address(cx)?, Backoff::default()), ()));
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(device) = &mut self.device else { return Ok(()) };
        for celsius in device.step(cx) {
            self.temperature.write(cx, celsius);
        }
        if !device.is_ready() {
            self.temperature.retract(cx);
        }
        device.export_connection(cx, &mut self.connection);
        Ok(())
    }

    /// Called when no awake schema needs the driver.
    fn sleep(&mut self, cx: &Context) {
        if let Some(device) = self.device.take() {
            device.close(cx, &mut self.connection);
            self.temperature.retract(cx);
        }
    }
}

impl __Name__ {
    fn address(&self, cx: &Context) -> Result<Address> {
        Ok(Address::parse(self.port.get(cx).as_str())?)
    }
}

/// Reports a wrong port before the application starts.
impl Inspect for __Name__ {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        inspect_port(&self.port, self.address(cx), problems);
    }
}

/// Logs the temperature once a second.
#[derive(Describe)]
#[schema(motor, period = "1s")]
pub struct Report {
    /// The temperature.
    #[import(unit = "degC")]
    temperature: Import<f64>,
}

impl Schema for Report {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(self.temperature.get(cx).is_some().into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        info!(cx, "temperature: {:.1} degrees Celsius", *self.temperature.require(cx)?);
        Ok(())
    }
}

jde_schema::export!("__name__", "A thermometer.", [__Name__, Report]);

#[cfg(test)]
mod tests {
    use jde_device::emulate::{DriverTest, EmulatedDevice};

    use super::*;
    use crate::emulator::EmulatedThermometer;

    #[test]
    fn it_reads_the_thermometer_until_the_connection_is_lost() {
        let (thermometer, path) = EmulatedDevice::at_pty(EmulatedThermometer { celsius: 21.5 });
        let mut driver = DriverTest::<__Name__>::with_port(&format!("serial:{}@9600", path.display()));
        driver.awake();
        driver.run_until(|bench| bench.exported("temperature") == Some(21.5));
        assert_eq!(driver.connection(), (Connection::CONNECTED, "a thermometer".to_owned()));
        thermometer.with(|thermometer| thermometer.celsius = -3.0);
        driver.run_until(|bench| bench.exported("temperature") == Some(-3.0));
        drop(thermometer);
        driver.wait_lost();
        assert_eq!(driver.bench.exported::<f64>("temperature"), None);
    }

    #[test]
    fn a_wrong_port_is_refused_before_the_start() {
        let driver = &mut DriverTest::<__Name__>::with_port("COM1").bench;
        let reason = driver.awake().unwrap_err().reason;
        let problems = driver.inspect().unwrap();
        assert!(problems.iter().any(|problem| !problem.unavailable && problem.words == reason));
    }
}
