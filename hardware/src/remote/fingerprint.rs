//! What mission and hardware must agree on, in a few numbers.
//!
//! Both read a configuration, and nothing but their user sees to it that it is the same one. Behaviours that take the ring for another
//! would see walls where there are none; so each side reckons the fingerprint of what it has read, and the mission compares.

use std::{fmt::Debug, time::Duration};

use orienteer_runtime::{
    robot_model::{Platform, Ring},
    topics::Fingerprint,
};

use crate::base::{executor::ExecutorConfig, protection::ProtectionConfig};

/// The fingerprint of a robot with a base of this driver, this body and this ring, driven once a `period`.
#[must_use]
pub fn fingerprint(
    driver: &str,
    platform: &Platform,
    ring: &Ring,
    motion: &ExecutorConfig,
    protection: &ProtectionConfig,
    period: Duration,
) -> Fingerprint {
    Fingerprint {
        period: u64::try_from(period.as_nanos()).unwrap_or(u64::MAX),
        platform: checksum(platform),
        ring: checksum(ring),
        driver: checksum(&driver),
        motion: checksum(motion),
        protection: checksum(protection),
        reserved: 0,
    }
}

/// What is different between the hardware's fingerprint and the mission's, for a person; `None` if nothing is.
#[must_use]
pub fn difference(hardware: &Fingerprint, mission: &Fingerprint) -> Option<String> {
    let mut parts = Vec::new();
    if hardware.period != mission.period {
        let rate = |period: u64| 1e9 / period.max(1) as f64;
        parts.push(format!("its control rate is {:.3} Hz, the mission's {:.3} Hz", rate(hardware.period), rate(mission.period)));
    }
    // How motions end and what protection reckons with follows from the driver, too: of these nobody has chosen another.
    let alike = hardware.driver == mission.driver;
    let others = [
        (!alike, "its base has another driver"),
        (hardware.platform != mission.platform, "its base is described in another way (`platform` or `custom`)"),
        (hardware.ring != mission.ring, "its sonar ring is another"),
        (alike && hardware.motion != mission.motion, "its `motion` or its `model` is another"),
        (alike && hardware.protection != mission.protection, "its `protection` is another"),
    ];
    parts.extend(others.iter().filter(|(differs, _)| *differs).map(|(_, text)| (*text).to_owned()));
    (!parts.is_empty()).then(|| parts.join(", "))
}

/// Of all that a value says of itself. It need not be secret, nor the same from version to version.
fn checksum(value: &impl Debug) -> u32 {
    crc32fast::hash(format!("{value:?}").as_bytes())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{base::presets, rings};

    #[test]
    fn what_is_different_is_named_and_nothing_else() {
        let platform = presets::by_name("p3dx").unwrap().platform();
        let ring = rings::find("p3dx-16").unwrap().ring;
        let plain = ExecutorConfig::default();
        let of = |platform: &Platform, ring: &Ring, protection: &ProtectionConfig, hertz: u32| {
            fingerprint("arcos", platform, ring, &plain, protection, Duration::from_secs(1) / hertz)
        };
        let usual = ProtectionConfig::default();
        let mission = of(&platform, &ring, &usual, 20);
        assert_eq!(difference(&of(&platform, &ring, &usual, 20), &mission), None);

        let told = |other: Fingerprint| difference(&other, &mission).unwrap();
        assert_eq!(told(of(&platform, &ring, &usual, 100)), "its control rate is 100.000 Hz, the mission's 20.000 Hz");
        let mut slower = platform.clone();
        slower.limits.linear *= 0.5;
        assert_eq!(told(of(&slower, &ring, &usual, 20)), "its base is described in another way (`platform` or `custom`)");
        let small = rings::find("amigobot-8").unwrap().ring;
        assert_eq!(told(of(&platform, &small, &usual, 20)), "its sonar ring is another");
        let bold = ProtectionConfig { margin: 0.5 * usual.margin, ..usual };
        assert_eq!(told(of(&platform, &ring, &bold, 20)), "its `protection` is another");
        let coarse = plain.clone().for_a_base(0.1, 0.1, 0.5);
        let other = fingerprint("arcos", &platform, &ring, &coarse, &usual, Duration::from_millis(50));
        assert_eq!(told(other), "its `motion` or its `model` is another");
        // That nobody has chosen.
        let other = fingerprint("create", &platform, &ring, &coarse, &bold, Duration::from_millis(50));
        assert_eq!(told(other), "its base has another driver");
        let other = told(of(&slower, &small, &bold, 10));
        assert_eq!(other.matches(", ").count(), 4, "{other}");
    }
}
