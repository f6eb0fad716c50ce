"""Makers of sealed cases: closed forms, Runge-Kutta with events, published layer tables. Imports neither minibullet nor hlcs.

One room per family (flight, sinking, bounce, slide, roll, topple, stack, layers) describes experiments; `motion`, `plane`
and `tilting` move bodies; `observe` films them; `noise` spoils the film; `strength` measures what a hidden law adds;
`build` and `tables` compose a case; `deck` deals what is hidden where; `seal` locks the answers.
"""
