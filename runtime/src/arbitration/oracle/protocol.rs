//! The protocol in its own words: messages, an owner, a stack, queues.

use std::collections::{BTreeMap, VecDeque};

use super::{History, Outcome, Step};
use crate::{
    geometry::Limits,
    time::Time,
    topics::{ArbitrationRule, BaseClaim, BaseDecision, BaseNotice, ClientId, HeldBack, Motion, MotionKind, NoticeKind},
};

/// What a client's claims amount to.
enum Message {
    /// A new transaction.
    Begin(u32),
    /// The transaction is over.
    End,
    /// The same number as before, once more.
    Again,
    /// Nothing has come for too long.
    Silence,
}

/// A client's letterbox: the newest claim, and what of it has been read.
#[derive(Default)]
struct Letterbox {
    letter: Option<BaseClaim>,
    silent: bool,
}

impl Letterbox {
    /// Reads this step's letters as messages.
    fn read(&mut self, letters: impl Iterator<Item = BaseClaim>, now: Time, mut tell: impl FnMut(Message)) {
        let read = self.letter;
        let mut came = false;
        for letter in letters {
            if self.letter.is_none_or(|newest| newest.stamp <= letter.stamp) {
                self.letter = Some(letter);
                came = true;
            }
        }
        let Some(letter) = self.letter else { return };
        let (before, number) = (read.map_or(0, |letter| letter.transaction), letter.transaction);
        if came {
            self.silent = false;
            match (before, number) {
                (before, number) if before == number => tell(Message::Again),
                (0, number) => tell(Message::Begin(number)),
                (_, 0) => tell(Message::End),
                (_, number) => {
                    tell(Message::End);
                    tell(Message::Begin(number));
                }
            }
        }
        if !self.silent && letter.valid_until <= now {
            self.silent = true;
            tell(Message::Silence);
        }
    }

    /// The claim that is in force.
    fn in_force(&self) -> Option<&BaseClaim> {
        self.letter.as_ref().filter(|_| !self.silent)
    }
}

/// A transaction that is not over.
#[derive(Clone, Copy)]
struct Session {
    client: ClientId,
    priority: u8,
    number: u32,
    /// When the base was given to it the last time.
    granted: Option<Time>,
}

/// The low-level controller.
struct Controller<'a> {
    priorities: &'a [u8],
    boxes: Vec<Letterbox>,
    owner: Option<Session>,
    overridden: Vec<Session>,
    queues: BTreeMap<u8, VecDeque<Session>>,
    refused: Vec<Option<(u32, NoticeKind)>>,
    last_command: Option<(ClientId, u32, Motion)>,
    told: Vec<BaseNotice>,
}

/// What the protocol answers to a history.
pub fn replay(history: &History) -> Vec<Outcome> {
    let clients = history.priorities.len();
    let mut controller = Controller {
        priorities: &history.priorities,
        boxes: (0..clients).map(|_| Letterbox::default()).collect(),
        owner: None,
        overridden: Vec::new(),
        queues: BTreeMap::new(),
        refused: vec![None; clients],
        last_command: None,
        told: Vec::new(),
    };
    history.steps.iter().map(|step| controller.step(step)).collect()
}

impl Controller<'_> {
    fn step(&mut self, step: &Step) -> Outcome {
        for (i, mut letterbox) in std::mem::take(&mut self.boxes).into_iter().enumerate() {
            let client = ClientId(i as u16);
            let letters = step.claims.iter().filter(|claim| claim.client == client).copied();
            letterbox.read(letters, step.now, |message| self.receive(client, message, step.now));
            self.boxes.push(letterbox);
        }
        let rule = self.hand_over(step.now);
        let decision = self.report(rule, step.now);
        self.forward_command(step.now);
        self.refuse_late(step.now);
        Outcome::new(decision, std::mem::take(&mut self.told))
    }

    fn receive(&mut self, client: ClientId, message: Message, now: Time) {
        let place = usize::from(client.0);
        match message {
            Message::Begin(number) => {
                let priority = self.priorities[place];
                let session = Session { client, priority, number, granted: None };
                self.queues.entry(priority).or_default().push_back(session);
            }
            Message::End => {
                self.remove(client);
                self.refused[place] = None;
            }
            Message::Again => {
                if let Some((number, kind)) = self.refused[place] {
                    self.told.push(BaseNotice::new(now, client, number, kind, ClientId::NONE));
                }
            }
            Message::Silence => {
                if let Some(session) = self.remove(client) {
                    self.refused[place] = Some((session.number, NoticeKind::Lapsed));
                    self.told.push(BaseNotice::new(now, client, session.number, NoticeKind::Lapsed, ClientId::NONE));
                }
            }
        }
    }

    /// Takes a client's transaction out, wherever it is.
    fn remove(&mut self, client: ClientId) -> Option<Session> {
        if self.owner.is_some_and(|owner| owner.client == client) {
            return self.owner.take();
        }
        if let Some(i) = self.overridden.iter().position(|session| session.client == client) {
            return Some(self.overridden.remove(i));
        }
        let queue = self.queues.get_mut(&self.priorities[usize::from(client.0)])?;
        let i = queue.iter().position(|session| session.client == client)?;
        queue.remove(i)
    }

    /// The queue whose turn it is.
    fn next_queue(&mut self) -> Option<&mut VecDeque<Session>> {
        self.queues.values_mut().rev().find(|queue| !queue.is_empty())
    }

    /// Finds the owner, tells whom it concerns, and says why.
    fn hand_over(&mut self, now: Time) -> ArbitrationRule {
        let front = self.next_queue().and_then(|queue| queue.front().copied());
        let mut by_turn = false;
        if let Some(owner) = self.owner {
            if let Some(front) = front.filter(|front| front.priority > owner.priority) {
                self.told.push(BaseNotice::new(now, owner.client, owner.number, NoticeKind::Overridden, front.client));
                self.overridden.push(owner);
                self.take_next(now);
            }
        } else if self.overridden.last().is_some_and(|top| front.is_none_or(|front| front.priority <= top.priority)) {
            self.owner = self.overridden.pop();
            self.grant(now);
        } else if front.is_some() {
            by_turn = true;
            self.take_next(now);
        }
        let Some(owner) = self.owner else { return ArbitrationRule::NobodyAsked };
        let priority = owner.priority;
        if self.queues.get(&priority).is_some_and(|equals| !equals.is_empty()) {
            // An override goes by turn as well, if several of the same priority come at once.
            let by_turn = by_turn || front.is_some_and(|front| (front.client, front.number) == (owner.client, owner.number));
            return if by_turn { ArbitrationRule::AskedFirst } else { ArbitrationRule::HeldFirst };
        }
        let alone = self.overridden.is_empty() && self.queues.values().all(VecDeque::is_empty);
        if alone { ArbitrationRule::OnlyClaim } else { ArbitrationRule::HigherPriority }
    }

    fn take_next(&mut self, now: Time) {
        self.owner = self.next_queue().and_then(VecDeque::pop_front);
        self.grant(now);
    }

    fn grant(&mut self, now: Time) {
        if let Some(owner) = &mut self.owner {
            owner.granted = Some(now);
            self.told.push(BaseNotice::new(now, owner.client, owner.number, NoticeKind::Granted, ClientId::NONE));
        }
    }

    fn motion_of(&self, client: ClientId) -> Motion {
        let Some(letter) = self.boxes[usize::from(client.0)].letter else { return Motion::STOP };
        match letter.motion.kind() {
            MotionKind::Stop => Motion::STOP,
            MotionKind::Velocity(twist) => Motion::velocity(twist),
            MotionKind::Translate { distance, speed } => Motion::translate(letter.motion.id, distance, speed),
            MotionKind::Rotate { angle, rate } => Motion::rotate(letter.motion.id, angle, rate),
        }
    }

    fn report(&self, rule: ArbitrationRule, now: Time) -> BaseDecision {
        let mut decision = BaseDecision::default().because(rule);
        (decision.stamp, decision.valid_until, decision.since) = (now, now, now);
        if let Some(owner) = self.owner {
            decision.holder = owner.client;
            decision.transaction = owner.number;
            decision.motion = self.motion_of(owner.client);
            decision.since = owner.granted.unwrap_or_default();
            decision.valid_until = self.boxes[usize::from(owner.client.0)].letter.map_or(now, |letter| letter.valid_until);
        }
        (decision.limits.linear, decision.limited_by) = self.lowest(|limits| limits.linear);
        (decision.limits.angular, decision.turn_limited_by) = self.lowest(|limits| limits.angular);
        for priority in (0..=u8::MAX).rev() {
            for session in self.overridden.iter().filter(|session| session.priority == priority) {
                decision.hold_back(HeldBack::new(session.client, ArbitrationRule::HangingOn));
            }
            for session in self.queues.get(&priority).into_iter().flatten() {
                let equal = self.owner.is_some_and(|owner| owner.priority == priority);
                let rule = if equal { ArbitrationRule::Queued } else { ArbitrationRule::LowerPriority };
                decision.hold_back(HeldBack::new(session.client, rule));
            }
        }
        decision
    }

    /// The lowest bound of one kind that anybody sets, and who sets it.
    fn lowest(&self, bound: impl Fn(&Limits) -> f64) -> (f64, ClientId) {
        let mut bounds: Vec<(f64, ClientId)> = Vec::new();
        for (i, claim) in self.boxes.iter().enumerate().filter_map(|(i, letterbox)| Some((i, letterbox.in_force()?))) {
            let bound = bound(&claim.limits);
            if bound.is_nan() || bound <= 0.0 {
                bounds.push((0.0, ClientId(i as u16)));
            } else if bound < f64::MAX {
                bounds.push((bound, ClientId(i as u16)));
            }
        }
        bounds.sort_by(|a, b| a.0.total_cmp(&b.0));
        bounds.first().copied().unwrap_or((f64::MAX, ClientId::NONE))
    }

    fn forward_command(&mut self, now: Time) {
        let command = self.owner.map(|owner| (owner.client, owner.number, self.motion_of(owner.client)));
        if let Some((by, _, motion)) = command.filter(|_| command != self.last_command) {
            for session in &self.overridden {
                let mut notice = BaseNotice::new(now, session.client, session.number, NoticeKind::OverriderMoves, by);
                notice.motion = motion;
                self.told.push(notice);
            }
        }
        self.last_command = command;
    }

    fn refuse_late(&mut self, now: Time) {
        let Some(owner) = self.owner else { return };
        for session in self.queues.values().flatten() {
            let place = usize::from(session.client.0);
            if self.boxes[place].letter.is_some_and(|letter| letter.wait_until <= now) {
                self.refused[place] = Some((session.number, NoticeKind::Busy));
                self.told.push(BaseNotice::new(now, session.client, session.number, NoticeKind::Busy, owner.client));
            }
        }
        let refused = &self.refused;
        for queue in self.queues.values_mut() {
            queue.retain(|session| refused[usize::from(session.client.0)].is_none());
        }
    }
}
