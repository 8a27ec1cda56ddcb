//! What the decisions of base and sonar have in common: the rule that decided, and who was held back.

use iceoryx2::prelude::ZeroCopySend;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ClientId;

/// Why a client was given the base (or the sonar), or was held back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ArbitrationRule {
    /// Nobody wants it.
    NobodyAsked,
    /// It is the only one that wants it.
    OnlyClaim,
    /// Its priority is strictly the highest.
    HigherPriority,
    /// Of equals, it had it first and keeps it.
    HeldFirst,
    /// Of equals, it asked first.
    AskedFirst,
    /// Held back: another's priority is higher.
    LowerPriority,
    /// Held back: it had it, was overridden and hangs on.
    HangingOn,
    /// Held back: an equal has it.
    Queued,
}

impl ArbitrationRule {
    const ALL: [ArbitrationRule; 8] = [
        ArbitrationRule::NobodyAsked,
        ArbitrationRule::OnlyClaim,
        ArbitrationRule::HigherPriority,
        ArbitrationRule::HeldFirst,
        ArbitrationRule::AskedFirst,
        ArbitrationRule::LowerPriority,
        ArbitrationRule::HangingOn,
        ArbitrationRule::Queued,
    ];

    pub(super) fn code(self) -> u16 {
        self as u16
    }

    pub(super) fn from_code(code: u16) -> Self {
        Self::ALL.get(usize::from(code)).copied().unwrap_or(ArbitrationRule::NobodyAsked)
    }
}

/// A client that wants the base (or the sonar) and does not have it, and why.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::HeldBack.v1")]
pub struct HeldBack {
    /// Who is held back.
    pub client: ClientId,
    /// [`ArbitrationRule`] as a number; see [`HeldBack::rule`].
    code: u16,
}

impl HeldBack {
    /// `client` is held back by `rule`.
    #[must_use]
    pub fn new(client: ClientId, rule: ArbitrationRule) -> Self {
        Self { client, code: rule.code() }
    }

    /// Why.
    #[must_use]
    pub fn rule(&self) -> ArbitrationRule {
        ArbitrationRule::from_code(self.code)
    }
}
