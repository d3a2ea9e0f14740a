//! A rate limit: a number of events per second, and as many at once after a pause as are stated.

use std::time::Instant;

/// A limit of events per second.
#[derive(Debug)]
pub struct TokenBucket {
    rate: f64,
    most: f64,
    tokens: f64,
    last: Instant,
}

impl TokenBucket {
    /// A limit of `rate` events per second, and as many at once.
    #[must_use]
    pub fn new(rate: f64, now: Instant) -> Self {
        Self::with_burst(rate, rate, now)
    }

    /// A limit of `rate` events per second, and of `most` at once.
    #[must_use]
    pub fn with_burst(rate: f64, most: f64, now: Instant) -> Self {
        Self {
            rate,
            most,
            tokens: most,
            last: now,
        }
    }

    /// Whether an event may occur now; if so, it counts.
    pub fn try_take(&mut self, now: Instant) -> bool {
        self.try_take_all(1, now)
    }

    /// Whether this number of events may occur now; if so, they count.
    pub fn try_take_all(&mut self, events: usize, now: Instant) -> bool {
        let passed = now.saturating_duration_since(self.last).as_secs_f64();
        self.tokens = (self.tokens + passed * self.rate).min(self.most);
        self.last = now;
        let is_allowed = self.tokens >= events as f64;
        if is_allowed {
            self.tokens -= events as f64;
        }
        is_allowed
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn unused_tokens_accumulate_for_one_second() {
        let start = Instant::now();
        let mut bucket = TokenBucket::new(10.0, start);
        let taken = |bucket: &mut TokenBucket, at| (0..100).filter(|_| bucket.try_take(at)).count();
        assert_eq!(taken(&mut bucket, start), 10);
        assert_eq!(taken(&mut bucket, start + Duration::from_millis(550)), 5);
        assert_eq!(taken(&mut bucket, start + Duration::from_secs(60)), 10);
    }

    #[test]
    fn several_events_count_together_or_not_at_all() {
        let start = Instant::now();
        let mut bucket = TokenBucket::with_burst(10.0, 30.0, start);
        assert!(!bucket.try_take_all(31, start));
        assert!(bucket.try_take_all(30, start));
        assert!(!bucket.try_take(start));
        assert!(bucket.try_take_all(10, start + Duration::from_millis(1050)));
        assert!(!bucket.try_take(start + Duration::from_millis(1050)));
    }
}
