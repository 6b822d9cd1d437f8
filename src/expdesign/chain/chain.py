"""The measurement chain of a robot with a set of effects, evaluated with exact sensitivities.

Δq = c∘τ, ΔX = J̌·Δq (theory.md 2.3) is what remains with no effects. The expression of one row is built once and mapped
over all rows; where effects carry states, the rows of every series are worked through in order, all series at once, and
the sensitivities of the states are carried along.
"""

from dataclasses import replace
from functools import cached_property

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import turned_lever, yielded
from expdesign.chain.declaration import Parameter
from expdesign.chain.effect import Effect
from expdesign.chain.readings.reading import DEFLECTION, Reading
from expdesign.chain.row import Row, RowData, row_symbols
from expdesign.mechanics.robots.orientation import rotation_vector
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.symbolic import BatchFunction, evaluate_through

Acting = list[tuple[Effect, ca.SX]]
"""Effects with their parameters."""
_LARGEST_CALL = 64
"""Most rows of a series with memory in one call: powers of two up to it make up every length."""
_FEW = 200
"""Rows of all that a chain was asked for up to which one component of a reading is differentiated at a time: of much
physics an expression of the whole Jacobian takes a second to build, and to evaluate half as long."""


class Chain:
    """Predicted deflections as a function of compliances and effect parameters.

    Args:
        robot: the robot.
        effects: physics beyond the base model, acting in this order within a link.
        instrument: whether the chain ends with the instrument's reading; otherwise with the motion of the platform.
        from_command: whether that motion is counted from the command, which the unloaded platform misses where its
            geometry is not nominal, or from where the unloaded platform stands. Of a robot that is commanded by a pose
            and whose readings are absolute; others do not tell.
        reading: what the instrument reads of the platform: its deflection, or positions of markers.

    Attributes:
        parameters: compliances first (`c1`, ... in units of 1/apK), then those of the instrument and its markers, then
            those of the effects.
    """

    def __init__(
        self,
        robot: Robot,
        effects: tuple[Effect, ...] = (),
        *,
        instrument: bool = True,
        from_command: bool = False,
        reading: Reading = DEFLECTION,
    ) -> None:
        self.robot = robot
        self.effects = effects
        self.instrument = instrument
        self.from_command = from_command and robot.on_legs
        compliances = tuple(
            Parameter(f"c{i + 1}", 1.0, neutral=1.0, low=1e-6, spread=reading.compliance_spread)
            for i in range(len(robot.stiffness))
        )
        self.reading = reading
        own = compliances + reading.parameters
        self.parameters = own + tuple(p for effect in effects for p in effect.parameters)
        self.slices: list[slice] = []
        self.base = start = len(own)
        for effect in effects:
            self.slices.append(slice(start, start + len(effect.parameters)))
            start += len(effect.parameters)
        self.states = sum(effect.states for effect in effects)
        self._several_rows: dict[tuple[bool, int, int], ca.Function] = {}
        self._asked = 0

    @property
    def linear(self) -> bool:
        """Whether it is linear in its parameters, which are the compliances alone."""
        return not self.effects and self.reading.linear

    @property
    def compliances(self) -> int:
        """Number of compliances, which come first among the parameters."""
        return len(self.robot.stiffness)

    def start(self) -> FloatArray:
        """Approximate compliances, instrument and markers as registered, and neutral effects, shape (p,)."""
        neutral = (effect.neutral() for effect in self.effects)
        return np.concatenate([np.ones(self.compliances), self.reading.start, *neutral])

    def knowledge(self, *, released: bool = False) -> tuple[FloatArray, FloatArray] | None:
        """Mean and standard deviation of the parameters before anything is measured, (p,) each; None for nothing.

        What is held because it is confounded with something else is held, or (`released`) as unknown as it really is.
        """
        spreads = np.array([parameter.spread for parameter in self.parameters])
        if released:
            read = slice(self.compliances, self.compliances + len(self.reading.parameters))
            spreads[read] = self.reading.released(spreads[read])
        if not np.isfinite(spreads).any():
            return None
        return np.array([parameter.neutral for parameter in self.parameters]), spreads

    def scales(self) -> FloatArray:
        """Typical size of every parameter, shape (p,)."""
        return np.array([parameter.scale for parameter in self.parameters])

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper bounds of the parameters, shape (p,) each."""
        return np.array([p.low for p in self.parameters]), np.array([p.high for p in self.parameters])

    def predict(self, rows: RowData, values: FloatArray) -> FloatArray:
        """Deflections as the instrument reads them (m, rad) at parameter values (p,), shape (N, n)."""
        return self._run(rows, values, derivatives=False)[0]

    def predict_with_sensitivities(self, rows: RowData, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Deflections (N, n) and their derivatives with respect to the parameters (N, n, p)."""
        deflections, sensitivities = self._run(rows, values, derivatives=True)
        assert sensitivities is not None
        return deflections, sensitivities

    @property
    def width(self) -> int:
        """Components of what the chain ends with."""
        return self.reading.width(self.robot) if self.instrument else self.robot.coordinates.n

    def row_symbols(self) -> Row:
        """Symbols of one row."""
        if not self.instrument:
            return row_symbols(self.robot)
        return row_symbols(
            self.robot, len(self.reading.names), len(self.reading.fixed), oriented=bool(self.reading.oriented)
        )

    @cached_property
    def counts_rows(self) -> bool:
        """Whether what it reads depends on the place of a row in the order of recording."""
        row, theta = self.row_symbols(), ca.SX.sym("theta", len(self.parameters))
        reading, _ = self.expression(row, ca.SX.sym("state", self.states), theta)
        return bool(ca.depends_on(reading, row.number))

    def expression(self, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Reading of one row and the next states, as expressions."""
        robot = self.robot
        acting = [(effect, theta[part]) for effect, part in zip(self.effects, self.slices, strict=True)]
        for effect, part in acting:
            row = self.reading.with_own_weight(row, effect.own_weight_change(row, part))
        forward, pose_map, wrench, pose = row.forward, row.pose_map, row.wrench, row.pose
        changed = any(effect.changes_geometry for effect in self.effects)
        compliance = theta[: self.compliances] / ca.SX(robot.stiffness) if self.compliances else ca.SX.zeros(0)
        errors = self._link_errors(acting)
        if changed and robot.jointed:
            forward, _, rotation = robot.links.jacobian_expressions(row.pose, errors)
            pose_map = forward
            wrench = row.wrench + turned_lever(rotation, row, row.wrench)
        elif changed:
            forward, pose_map, wrench, pose = self._with_true_legs(row, compliance, acting)
        for effect, part in acting:
            wrench = effect.load(wrench, effect.seen(row), part)
        force = forward.T @ wrench + row.carried if self.compliances else ca.SX.zeros(0)
        elongation, states = self._elongated(force, compliance, row, state, acting)
        if self.compliances and robot.jointed and self.reading.absolute:
            force, wrench = self._force_where_it_stands(row, elongation, acting, errors)
            elongation, states = self._elongated(force, compliance, row, state, acting)
            deflection = self._moved_tip(row, elongation, errors)
        else:
            deflection = pose_map @ elongation if self.compliances else ca.SX.zeros(robot.coordinates.n)
        following = [ca.SX.zeros(0)]
        for (effect, part), own in zip(acting, states, strict=True):
            deflection = effect.structure(deflection, wrench, compliance, effect.seen(row), part)
            deflection, next_own = effect.structure_with_memory(deflection, wrench, effect.seen(row), own, part)
            following.append(next_own)
        reading = deflection
        unknown, stands = theta[self.compliances : self.base], replace(row, pose=pose)
        if self.instrument:
            reading = self.reading.expression(robot, deflection, stands, unknown, errors)
            for effect, part in acting if self.reading.by_instrument else ():
                reading = effect.reading(reading, effect.seen(row), part)
        elif self.from_command:
            reading = self.reading.displacement(robot, deflection, stands, unknown, row.pose)
        return reading, ca.vertcat(*following)

    def _elongated(
        self, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, acting: Acting
    ) -> tuple[ca.SX, list[ca.SX]]:
        """Length changes of the actuators (n_p,) under their forces, and the next states of every effect."""
        elongation = compliance * force
        states, offset = [], 0
        for effect, part in acting:
            # An empty slice of a CasADi scalar is a row, and would spoil the stack of states.
            own = state[offset : offset + effect.states] if effect.states else ca.SX.zeros(0)
            elongation, own = effect.actuator(elongation, force, compliance, effect.seen(row), own, part)
            states.append(own)
            offset += effect.states
        return elongation, states

    def _force_where_it_stands(
        self, row: Row, elongation: ca.SX, acting: Acting, errors: ca.SX | None
    ) -> tuple[ca.SX, ca.SX]:
        """Actuator forces (n_p,) and the wrench (n,) on an arm whose joints have yielded by `elongation`.

        τ(q + δ) = J(q + δ)ᵀ·F(q + δ) + τ_g(q + δ) with δ = c∘τ(q): one step of the fixed point of δ = c∘τ(q + δ), which
        is the equilibrium to second order. Readings of where an arm stands contain it; differences hardly do.
        """
        links, q = self.robot.links, ca.SX.sym("q", row.pose.shape[0])
        forward, pose_map, rotation = links.jacobian_expressions(q, errors)
        stands = replace(
            row, pose=q, forward=forward, pose_map=pose_map, rotation=rotation,
            wrench=row.wrench + turned_lever(rotation, row, row.wrench),
            lever=rotation @ row.rotation.T @ row.lever, carried=links.own_weight_expression(q, row.gravity),
        )  # fmt: skip
        for effect, part in acting:
            stands = self.reading.with_own_weight(stands, effect.own_weight_change(stands, part))
        wrench = stands.wrench
        for effect, part in acting:
            wrench = effect.load(wrench, effect.seen(stands), part)
        force = forward.T @ wrench + stands.carried
        force, wrench = ca.substitute([force, wrench], [q], [yielded(row.pose, elongation)])
        return force, wrench

    def _moved_tip(self, row: Row, elongation: ca.SX, errors: ca.SX | None) -> ca.SX:
        """How far the tip of an arm is from where it were if no joint yielded, exactly: in pose coordinates (n,)."""
        links = self.robot.links
        position, rotation = links.tip(row.pose, errors)
        moved, turned = links.tip(yielded(row.pose, elongation), errors)
        return ca.vertcat(moved - position, rotation_vector(turned @ rotation.T))

    def _with_true_legs(self, row: Row, compliance: ca.SX, acting: Acting) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        """J, J̌, the wrench and the pose to which the commanded lengths lead with the true geometry.

        The commanded lengths are those of the nominal geometry at the commanded pose. Chord steps
        X ← X − J̌·(q(X; true) − q) find the true pose up to a power of the error by one higher than their number; there
        a payload's lever has turned with the platform.
        """
        robot = self.robot.inverse_kinematics
        geometry = nominal = ca.SX(robot.geometry)
        commanded = nominal_lengths = robot.actuator_lengths(row.pose, nominal)
        for effect, part in acting:
            geometry, commanded = effect.geometry(geometry, part), effect.lengths(commanded, part)
        pose = row.pose
        unchanged = geometry is nominal and commanded is nominal_lengths
        for _ in range(0 if unchanged else self.reading.chord_steps):
            pose = pose - row.pose_map @ (robot.actuator_lengths(pose, geometry) - commanded)
        for effect, part in acting:
            pose = effect.unloaded(pose, compliance, effect.seen(row), part)
        n = self.robot.coordinates.n
        symbol = ca.SX.sym("X", n)
        rates = ca.jacobian(robot.actuator_lengths(symbol, geometry), symbol)
        pose_map = ca.solve(ca.substitute(rates, symbol, pose), ca.SX.eye(n))
        forward = ca.solve(ca.substitute(robot.pose_rate_map(symbol), symbol, pose), pose_map)
        return forward, pose_map, row.wrench + turned_lever(robot.rotation(pose), row, row.wrench), pose

    def _link_errors(self, acting: Acting) -> ca.SX | None:
        """Geometric errors of links with the effects that change them; None without links or such effects."""
        if not self.robot.jointed:
            return None
        geometry = nominal = ca.SX.zeros(self.robot.links.tree.size)
        for effect, part in acting:
            geometry = effect.geometry(geometry, part)
        return None if geometry is nominal else geometry

    @cached_property
    def _symbolic(self) -> tuple[Row, ca.SX, ca.SX, ca.SX, ca.SX]:
        row = self.row_symbols()
        state = ca.SX.sym("state", self.states)
        theta = ca.SX.sym("theta", len(self.parameters))
        found = [*self.expression(row, state, theta)]
        # Links make the same expressions anew: kept once, derivatives of them are taken once as well.
        reading, following = ca.cse(found) if self.robot.jointed else found
        return row, state, theta, reading, following

    @cached_property
    def _value(self) -> BatchFunction:
        row, _, theta, reading, _ = self._symbolic
        return BatchFunction("chain", [row.flat(), theta], [reading])

    @cached_property
    def _derivatives(self) -> BatchFunction:
        row, _, theta, reading, _ = self._symbolic
        return BatchFunction("chain_derivatives", [row.flat(), theta], [reading, ca.jacobian(reading, theta)])

    @cached_property
    def _derivatives_along(self) -> BatchFunction:
        """Derivatives of the reading's component along a direction."""
        row, _, theta, reading, _ = self._symbolic
        along = ca.SX.sym("along", self.width)
        return BatchFunction("chain_along", [row.flat(), theta, along], [ca.jtimes(reading, theta, along, True)])

    def sensitivities(self, rows: RowData, values: FloatArray) -> FloatArray:
        """Derivatives (N, n, p) alone, of the first few rows by one component after the other."""
        self._asked += len(rows)
        if self.states or self._asked > _FEW:
            return self.predict_with_sensitivities(rows, values)[1]
        return self._derivatives_along(rows.values[:, None], values, np.eye(self.width))[0]

    @cached_property
    def _next(self) -> ca.Function:
        """One row after the other: states and the reading."""
        row, state, theta, reading, following = self._symbolic
        return ca.Function("next", [state, row.flat(), theta], [ca.densify(following), ca.densify(reading)])

    @cached_property
    def _next_derivatives(self) -> ca.Function:
        """`_next` with the sensitivities that states carry along, and total sensitivities of the reading."""
        row, state, theta, reading, following = self._symbolic
        carried = ca.SX.sym("carried", self.states, len(self.parameters))
        # Taken at once, derivatives share terms.
        whole = ca.jacobian(ca.vertcat(reading, following), ca.vertcat(theta, state))
        by_theta, by_state = ca.horzsplit(whole, [0, len(self.parameters), whole.size2()])
        total, through = ca.vertsplit(by_theta + by_state @ carried, [0, self.width, whole.size1()])
        before, after = ca.vertcat(state, ca.vec(carried)), ca.vertcat(following, ca.vec(through))
        outputs = [ca.densify(after), ca.densify(ca.vertcat(reading, ca.vec(total)))]
        return ca.Function("next_derivatives", [before, row.flat(), theta], outputs)

    def _run(self, rows: RowData, values: FloatArray, *, derivatives: bool) -> tuple[FloatArray, FloatArray | None]:
        """Readings (N, k), and where they are asked for their derivatives (N, k, p)."""
        if self.states:
            return self._run_in_order(rows, values, derivatives=derivatives)
        found = (self._derivatives if derivatives else self._value)(rows.values, values)
        shape = (len(rows), self.width, len(values))
        return found[0].reshape(shape[:2]), found[1].reshape(shape) if derivatives else None

    def _run_in_order(
        self, rows: RowData, values: FloatArray, *, derivatives: bool
    ) -> tuple[FloatArray, FloatArray | None]:
        """`_run` with memory: one call takes the next rows of all series that are long enough, in powers of two."""
        count, width, n = len(rows), len(values), self.width
        readings, sensitivities = np.zeros((count, n)), np.zeros((count, n, width) if derivatives else 0)
        order, left = np.lexsort((rows.position, rows.series)), np.bincount(rows.series)
        begin = np.cumsum(left) - left
        state = np.zeros((len(left), self.states * (1 + width * derivatives)))
        while left.any():
            length = min(_LARGEST_CALL, 1 << (int(left.max()).bit_length() - 1))
            series = np.flatnonzero(left >= length)
            part = order[begin[series][:, None] + np.arange(length)]
            function = self._consecutive(derivatives, length, len(series))
            given = [
                np.ascontiguousarray(array, dtype=np.float64)
                for array in (state[series], rows.values[part], np.broadcast_to(values, (*part.shape, width)))
            ]
            # CasADi stores columns first, of which it has one for every row.
            states, output = (np.empty((*part.shape, function.size1_out(index))) for index in (0, 1))
            evaluate_through(function.buffer(), given, (states, output))
            readings[part] = output[..., :n]
            if derivatives:
                sensitivities[part] = output[..., n:].reshape(*part.shape, width, n).swapaxes(-1, -2)
            state[series] = states[:, -1]
            begin[series] += length
            left[series] -= length
        return readings, sensitivities if derivatives else None

    def _consecutive(self, derivatives: bool, length: int, series: int) -> ca.Function:
        """`length` rows of each of several series in one call. Few sizes are made, because each keeps what it needs."""
        key = (derivatives, length, series)
        if key not in self._several_rows:
            following = self._next_derivatives if derivatives else self._next
            self._several_rows[key] = following.mapaccum(length).map(series)
        return self._several_rows[key]
