//! Emulates the device until Enter is pressed.

use jde_device::emulate::EmulatedDevice;

#[path = "../src/emulator.rs"]
mod emulator;

fn main() -> std::io::Result<()> {
    let (_device, address) = EmulatedDevice::at_tcp(emulator::EmulatedThermometer { celsius: 21.5 }, 9600);
    println!("in another terminal, type: __jde__ run app.toml --set __name__.port={address} --log report=info");
    println!("press Enter to end the emulation");
    std::io::stdin().read_line(&mut String::new())?;
    Ok(())
}
