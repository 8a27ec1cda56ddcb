//! The parts of a robot whose keys only the catalogue knows: drivers and agents.

use schemars::Schema;

use super::{
    AgentConfig, DriverConfig,
    catalog::{AgentInfo, Catalog, DriverInfo},
    keys::{AgentTable, BaseTable, MissionFile, SonarTable},
    names,
};
use crate::config::{
    document::{Section, Table},
    problem::Problem,
    source::Sources,
    suggest,
    validate::{self, Rules},
};

/// What parts are checked with.
pub(super) struct Checker<'a> {
    pub(super) sources: &'a Sources,
    pub(super) catalog: &'a dyn Catalog,
    agent_keys: Schema,
    base_keys: Schema,
    sonar_keys: Schema,
}

/// Which of the two devices.
#[derive(Clone, Copy)]
pub(super) enum Device {
    Base,
    Sonar,
}

impl Device {
    pub(super) fn key(self) -> &'static str {
        match self {
            Device::Base => "base",
            Device::Sonar => "sonar",
        }
    }

    fn info<'a>(self, catalog: &'a dyn Catalog, name: &str) -> Option<&'a DriverInfo> {
        match self {
            Device::Base => catalog.base_driver(name),
            Device::Sonar => catalog.sonar_driver(name),
        }
    }

    fn all(self, catalog: &dyn Catalog) -> Vec<String> {
        match self {
            Device::Base => catalog.base_drivers(),
            Device::Sonar => catalog.sonar_drivers(),
        }
    }
}

impl<'a> Checker<'a> {
    pub(super) fn new(sources: &'a Sources, catalog: &'a dyn Catalog) -> Self {
        Self {
            sources,
            catalog,
            agent_keys: closed::<AgentTable>(),
            base_keys: closed::<BaseTable>(),
            sonar_keys: closed::<SonarTable>(),
        }
    }

    /// A device of a robot or, if `partial`, of a template. `None` if it has none, or has problems.
    pub(super) fn device(
        &self,
        robot: &Section,
        device: Device,
        partial: bool,
        problems: &mut Vec<Problem>,
    ) -> Option<(DriverConfig, &'a DriverInfo)> {
        let section = robot.section(device.key())?;
        let all = device.all(self.catalog);
        let all = || all.iter().map(String::as_str);
        let Some(name) = section.text("driver") else {
            // A driver that is no text was reported with the file as a whole.
            if !partial && !section.table().contains_key("driver") {
                let hint = format!("add `driver = \"…\"`, one of {}", suggest::list(all()));
                problems.push(Problem::new(self.sources, &section.span(), format!("the {} has no driver", device.key()), hint));
            }
            return None;
        };
        let Some(info) = device.info(self.catalog, name) else {
            let message = format!("there is no {} driver `{name}`", device.key());
            let hint = suggest::hint(name, "known are", all());
            problems.push(Problem::new(self.sources, &section.span_of("driver"), message, hint));
            return None;
        };
        let title = format!("the {} with driver `{name}`", device.key());
        let common = match device {
            Device::Base => &self.base_keys,
            Device::Sonar => &self.sonar_keys,
        };
        self.check(&section, &info.schema, common, partial, &title, problems).then(|| {
            let own = without(&section, &["driver"]);
            (DriverConfig { name: name.to_owned(), span: section.span_of("driver"), section: own }, info)
        })
    }

    /// All agents of a robot or, if `partial`, of a template, with what the catalogue knows of them; without those that have
    /// problems.
    pub(super) fn agents(
        &self,
        robot: &Section,
        partial: bool,
        problems: &mut Vec<Problem>,
    ) -> Vec<(AgentConfig, bool, &'a AgentInfo)> {
        let Some(agents) = robot.section("agent") else { return Vec::new() };
        let mut found = Vec::new();
        for (key, value) in agents.table() {
            let name = key.get_ref().as_str();
            if let Err((message, hint)) = names::check(name, "agent", names::TAKEN_FROM_AGENTS) {
                problems.push(Problem::new(self.sources, &key.span(), message, hint));
            }
            let Some(table) = value.get_ref().as_table() else { continue };
            let section = Section::new(table.clone(), value.span());
            if table.contains_key("kind") && section.text("kind").is_none() {
                continue;
            }
            let kind = section.text("kind").unwrap_or(name);
            let Some(info) = self.catalog.agent(kind) else {
                let at = if table.contains_key("kind") { section.span_of("kind") } else { key.span() };
                problems.push(self.unknown_kind(kind, !table.contains_key("kind"), &at));
                continue;
            };
            let title = if kind == name { format!("the agent `{name}`") } else { format!("the agent `{name}` of kind `{kind}`") };
            if self.check(&section, &info.schema, &self.agent_keys, partial, &title, problems) {
                let span = key.span();
                found.extend(self.agent(name, kind, &section, info, span, problems));
            }
        }
        found
    }

    fn agent(
        &self,
        name: &str,
        kind: &str,
        section: &Section,
        info: &'a AgentInfo,
        span: crate::config::Span,
        problems: &mut Vec<Problem>,
    ) -> Option<(AgentConfig, bool, &'a AgentInfo)> {
        if section.table().contains_key("priority") && !info.claims() {
            let message = format!("`priority` means nothing here: agents of kind `{kind}` never ask for the base or the sonar");
            problems.push(Problem::new(self.sources, &section.span_of_key("priority"), message, "remove the line"));
        }
        let common: AgentTable = match section.deserialize(self.sources) {
            Ok(common) => common,
            Err(refused) => {
                problems.extend(refused.into_list());
                return None;
            }
        };
        let config = AgentConfig {
            name: name.to_owned(),
            kind: kind.to_owned(),
            priority: common.priority.unwrap_or(info.priority),
            deadline: common.deadline_ms.map(|ms| ms / 1000.0),
            span,
            section: without(section, &["kind", "priority", "enabled", "deadline_ms"]),
        };
        Some((config, common.enabled, info))
    }

    fn unknown_kind(&self, kind: &str, by_name: bool, at: &crate::config::Span) -> Problem {
        let kinds = self.catalog.agent_kinds();
        let kinds = || kinds.iter().map(String::as_str);
        let list = format!("known are {}", suggest::list(kinds()));
        let hint = match (suggest::did_you_mean(kind, kinds()), by_name) {
            (Some(question), true) => format!("{question} A name of your own needs a `kind`; {list}"),
            (None, true) => format!("an agent's name is its kind unless you give a `kind`; {list}"),
            (Some(question), false) => format!("{question} ({list})"),
            (None, false) => list,
        };
        Problem::new(self.sources, at, format!("there is no agent kind `{kind}`"), hint)
    }

    /// True if the table is as its kind wants it.
    fn check(
        &self,
        section: &Section,
        schema: &Schema,
        common: &Schema,
        partial: bool,
        name: &str,
        problems: &mut Vec<Problem>,
    ) -> bool {
        let names = |sort: &str| self.catalog.names(sort);
        let elsewhere = |key: &str| owner(key, self.catalog);
        let rules = Rules { schema, common: Some(common), partial, name, names: &names, elsewhere: &elsewhere };
        let found = validate::check(section, &rules, self.sources);
        let fine = found.is_empty();
        problems.extend(found);
        fine
    }
}

/// Who has a key of this name.
pub(super) fn owner(key: &str, catalog: &dyn Catalog) -> Option<String> {
    let has = |schema: &Schema| schema.get("properties").is_some_and(|properties| properties.get(key).is_some());
    let kinds = catalog.agent_kinds();
    if let Some(kind) = kinds.iter().find(|kind| catalog.agent(kind).is_some_and(|info| has(&info.schema))) {
        return Some(format!("agents of kind `{kind}`"));
    }
    let driver = [Device::Base, Device::Sonar].into_iter().find_map(|device| {
        let drivers = device.all(catalog);
        let driver = drivers.iter().find(|name| device.info(catalog, name).is_some_and(|info| has(&info.schema)))?;
        Some(format!("the {} driver `{driver}`", device.key()))
    });
    let tables =
        [("RobotKeys", "`[[robot]]`"), ("MissionKeys", "`[mission]`"), ("WorldKeys", "`[world]`"), ("RecordKeys", "`[record]`")];
    driver.or_else(|| {
        let mission = validate::schema_of::<MissionFile>();
        let known = |table: &str| mission.pointer(&format!("/$defs/{table}/properties/{key}")).is_some();
        tables.into_iter().find(|(table, _)| known(table)).map(|(_, header)| header.to_owned())
    })
}

/// The schema of keys that may stand beside others, without leave for others.
fn closed<T: schemars::JsonSchema>() -> Schema {
    let mut schema = validate::schema_of::<T>();
    schema.remove("additionalProperties");
    schema
}

fn without(section: &Section, keys: &[&str]) -> Section {
    let table: Table = section
        .table()
        .iter()
        .filter(|(key, _)| !keys.contains(&key.get_ref().as_str()))
        .map(|(key, value)| (key.clone(), value.clone()))
        .collect();
    Section::new(table, section.span())
}
