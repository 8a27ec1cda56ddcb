//! What a base says when it is asked for its settings: limits that it will not exceed, and what it is equipped with.

use super::frame::{self, Frame};
use crate::wire::{PacketError, fields::Fields};

const KIND: u8 = 0x20;

/// The settings that matter to a client. The packet has more, for tuning its motors.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Settings {
    /// Class of the robot, as in its greeting.
    pub class: String,
    /// Its model, as in its greeting.
    pub model: String,
    /// Serial number.
    pub serial_number: String,
    /// Turn rate that can't be exceeded whatever is set, °/s.
    pub greatest_turn_rate: u16,
    /// Speed that can't be exceeded whatever is set, mm/s.
    pub greatest_speed: u16,
    /// The robot's own name.
    pub name: String,
    /// Time between two information packets, ms.
    pub cycle: u8,
    /// Whether it has sonars in front.
    pub front_sonar: bool,
    /// Whether it has sonars at the rear.
    pub rear_sonar: bool,
    /// The base stops when it has heard nothing for so long, ms.
    pub watchdog: u16,
    /// Turn rate when it drives on its own, °/s.
    pub top_turn_rate: u16,
    /// Speed when it drives on its own, mm/s.
    pub top_speed: u16,
    /// Angular acceleration, °/s².
    pub angular_acceleration: u16,
    /// Angular deceleration, °/s².
    pub angular_deceleration: u16,
    /// Acceleration, mm/s².
    pub acceleration: u16,
    /// Deceleration, mm/s².
    pub deceleration: u16,
    /// Segments of the front bumper.
    pub front_bumpers: u8,
    /// Segments of the rear bumper.
    pub rear_bumpers: u8,
    /// Time between two sonar pings of an array, ms.
    pub sonar_cycle: u8,
}

impl Settings {
    /// Understands a frame.
    ///
    /// # Errors
    /// If it is of another kind or too short. What comes behind the last field here may be anything.
    pub fn parse(frame: Frame<'_>) -> Result<Self, PacketError> {
        if frame.kind != KIND {
            return Err(PacketError::OtherKind { found: frame.kind, wanted: "settings" });
        }
        let mut fields = Fields(frame.body);
        let mut settings = Self {
            class: text(&mut fields, "class")?,
            model: text(&mut fields, "model")?,
            serial_number: text(&mut fields, "serial number")?,
            ..Self::default()
        };
        fields.skip(1, "a byte of old")?;
        settings.greatest_turn_rate = fields.u16("greatest turn rate")?;
        settings.greatest_speed = fields.u16("greatest speed")?;
        fields.skip(6, "greatest accelerations and motor power")?;
        settings.name = text(&mut fields, "name")?;
        settings.cycle = fields.u8("cycle")?;
        fields.skip(4, "baud rates and gripper")?;
        settings.front_sonar = fields.u16("front sonar")? != 0;
        settings.rear_sonar = fields.u8("rear sonar")? != 0;
        fields.skip(4, "low battery and turns of a wheel")?;
        settings.watchdog = fields.u16("watchdog")?;
        fields.skip(9, "kind of information, stall and joystick")?;
        settings.top_turn_rate = fields.u16("turn rate")?;
        settings.top_speed = fields.u16("speed")?;
        settings.angular_acceleration = fields.u16("angular acceleration")?;
        settings.angular_deceleration = fields.u16("angular deceleration")?;
        fields.skip(6, "gains of turning")?;
        settings.acceleration = fields.u16("acceleration")?;
        settings.deceleration = fields.u16("deceleration")?;
        fields.skip(6, "gains of driving")?;
        settings.front_bumpers = fields.u8("front bumpers")?;
        settings.rear_bumpers = fields.u8("rear bumpers")?;
        fields.skip(1, "charger")?;
        settings.sonar_cycle = fields.u8("sonar cycle")?;
        Ok(settings)
    }

    /// Appends the frame. What is left out here is zero; of each name 30 bytes go.
    pub fn emit(&self, into: &mut Vec<u8>) {
        let mut body = Vec::with_capacity(frame::MOST);
        put_text(&mut body, &self.class);
        put_text(&mut body, &self.model);
        put_text(&mut body, &self.serial_number);
        body.push(0);
        put(&mut body, &[self.greatest_turn_rate, self.greatest_speed, 0, 0, 0]);
        put_text(&mut body, &self.name);
        body.extend([self.cycle, 0, 0, 0, 0]);
        put(&mut body, &[self.front_sonar.into()]);
        body.push(self.rear_sonar.into());
        put(&mut body, &[0, 0, self.watchdog]);
        body.push(0);
        put(&mut body, &[0, 0, 0, 0, self.top_turn_rate, self.top_speed]);
        put(&mut body, &[self.angular_acceleration, self.angular_deceleration, 0, 0, 0]);
        put(&mut body, &[self.acceleration, self.deceleration, 0, 0, 0]);
        body.extend([self.front_bumpers, self.rear_bumpers, 0, self.sonar_cycle]);
        frame::emit(KIND, &body, into);
    }
}

fn text(fields: &mut Fields<'_>, field: &'static str) -> Result<String, PacketError> {
    fields.text(field).map(|text| String::from_utf8_lossy(text).into_owned())
}

fn put_text(body: &mut Vec<u8>, text: &str) {
    body.extend(text.bytes().take(30).take_while(|byte| *byte != 0));
    body.push(0);
}

fn put(body: &mut Vec<u8>, numbers: &[u16]) {
    body.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    prop_compose! {
        fn settings()(names in proptest::array::uniform4("[A-Za-z0-9_-]{0,30}"), words: [u16; 9], bytes: [u8; 4], sonars: [bool; 2]) -> Settings {
            let [class, model, serial_number, name] = names;
            let [cycle, front_bumpers, rear_bumpers, sonar_cycle] = bytes;
            Settings {
                class,
                model,
                serial_number,
                greatest_turn_rate: words[0],
                greatest_speed: words[1],
                name,
                cycle,
                front_sonar: sonars[0],
                rear_sonar: sonars[1],
                watchdog: words[2],
                top_turn_rate: words[3],
                top_speed: words[4],
                angular_acceleration: words[5],
                angular_deceleration: words[6],
                acceleration: words[7],
                deceleration: words[8],
                front_bumpers,
                rear_bumpers,
                sonar_cycle,
            }
        }
    }

    proptest! {
        #[test]
        fn settings_come_back(settings in settings()) {
            let mut bytes = Vec::new();
            settings.emit(&mut bytes);
            prop_assert_eq!(frame::each(&bytes, Settings::parse), [Ok(settings)]);
        }

        #[test]
        fn nonsense_is_refused_and_not_feared(body in proptest::collection::vec(any::<u8>(), 0..199)) {
            let _ = Settings::parse(Frame { kind: KIND, body: &body });
        }
    }

    /// The offsets of the manual's table, counted by hand for names of three letters.
    #[test]
    fn the_fields_lie_where_the_manual_says() {
        let three = || "abc".to_owned();
        let mut settings =
            Settings { class: three(), model: three(), serial_number: three(), name: three(), ..Settings::default() };
        let set: [(usize, fn(&mut Settings)); 7] = [
            (13, |s| s.greatest_turn_rate = 0xAA),
            (15, |s| s.greatest_speed = 0xAA),
            (27, |s| s.cycle = 0xAA),
            (39, |s| s.watchdog = 0xAA),
            (50, |s| s.top_turn_rate = 0xAA),
            (64, |s| s.acceleration = 0xAA),
            (77, |s| s.sonar_cycle = 0xAA),
        ];
        for (place, set) in set {
            let before = settings.clone();
            set(&mut settings);
            let mut bytes = Vec::new();
            settings.emit(&mut bytes);
            assert_eq!(bytes[4 + place], 0xAA, "{place}: {settings:?}");
            settings = before;
        }
    }
}
