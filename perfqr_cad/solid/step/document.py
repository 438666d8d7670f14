"""The product structure around solids: units, names, colours, layers, measures, an assembly of several (ISO
10303-242)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from perfqr_cad.solid.step.text import PROTOCOL, UNIT_DIGITS, Part21, reals, refs, text
from perfqr_cad.solid.step.validation import Measures, Validation

UNCERTAINTY = "1.E-06"  # mm: vertices and edges meet within it


@dataclass(frozen=True)
class StepBody:
    """A solid already written: its entity, name, sRGB colour, what is measured on it, and the representation
    that holds it."""

    entity: int
    name: str
    colour: tuple[float, float, float]
    measures: Measures
    representation: str = "ADVANCED_BREP_SHAPE_REPRESENTATION"


@dataclass(frozen=True)
class _Product:
    definition: int
    representation: int


class Document:
    """One part, or an assembly of parts, in mm."""

    def __init__(self, part: Part21) -> None:
        self._add = add = part.add
        protocol, year = PROTOCOL
        application = add("APPLICATION_CONTEXT('managed model based 3d engineering')")
        add(f"APPLICATION_PROTOCOL_DEFINITION('international standard','{protocol}',{year},#{application})")
        self._mechanical = add(f"PRODUCT_CONTEXT('',#{application},'mechanical')")
        self._design = add(f"PRODUCT_DEFINITION_CONTEXT('part definition',#{application},'design')")
        length, self._space = self._units()
        self._validation = Validation(part, length, self._space)
        origin = part.shared("CARTESIAN_POINT('',(0.,0.,0.))")
        z, x = part.shared("DIRECTION('',(0.,0.,1.))"), part.shared("DIRECTION('',(1.,0.,0.))")
        self._axes = lambda: add(f"AXIS2_PLACEMENT_3D('',#{origin},#{z},#{x})")
        self._root = self._axes()

    def write(self, bodies: Sequence[StepBody], product: str) -> None:
        """Name, colour and place the bodies: one product when alone, else parts of an assembly."""
        self._style(bodies)
        if len(bodies) == 1:
            self._part(bodies[0], product)
            return
        parts = [(body.name, self._part(body, body.name)) for body in bodies]
        places = [self._axes() for _ in parts]
        shape = self._add(
            f"SHAPE_REPRESENTATION({text(product)},{refs([self._root, *places])},#{self._space})"
        )
        assembly = self._product(product, shape)
        for (name, part), place in zip(parts, places, strict=True):
            self._use(assembly, part, name, place)

    def _units(self) -> tuple[int, int]:
        """The unit of lengths, and the context that all shapes lie in."""
        add = self._add
        length = add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
        angle = add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
        solid_angle = add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
        within = add(
            f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({UNCERTAINTY}),#{length},"
            "'distance_accuracy_value','confusion accuracy')"
        )
        context = add(
            f"(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#{within}))"
            f"GLOBAL_UNIT_ASSIGNED_CONTEXT((#{length},#{angle},#{solid_angle}))REPRESENTATION_CONTEXT('3D','3D'))"
        )
        return length, context

    def _part(self, body: StepBody, product: str) -> _Product:
        shape = self._add(
            f"{body.representation}({text(body.name)},(#{self._root},#{body.entity}),#{self._space})"
        )
        return self._product(product, shape, body.measures)

    def _product(self, name: str, shape: int, measures: Measures | None = None) -> _Product:
        add = self._add
        product = add(f"PRODUCT({text(name)},{text(name)},'',(#{self._mechanical}))")
        add(f"PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#{product}))")
        formation = add(f"PRODUCT_DEFINITION_FORMATION('','',#{product})")
        definition = add(f"PRODUCT_DEFINITION('design','',#{formation},#{self._design})")
        shape_of = add(f"PRODUCT_DEFINITION_SHAPE('','',#{definition})")
        add(f"SHAPE_DEFINITION_REPRESENTATION(#{shape_of},#{shape})")
        if measures is not None:
            self._validation.write(shape_of, measures)
        return _Product(definition, shape)

    def _use(self, assembly: _Product, part: _Product, name: str, place: int) -> None:
        """An occurrence of a part in the assembly, where it was modelled."""
        add = self._add
        use = add(
            f"NEXT_ASSEMBLY_USAGE_OCCURRENCE({text(name)},{text(name)},'',"
            f"#{assembly.definition},#{part.definition},$)"
        )
        shape_of = add(f"PRODUCT_DEFINITION_SHAPE('','',#{use})")
        move = add(f"ITEM_DEFINED_TRANSFORMATION('','',#{self._root},#{place})")
        relation = add(
            f"(REPRESENTATION_RELATIONSHIP('','',#{part.representation},#{assembly.representation})"
            f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{move})SHAPE_REPRESENTATION_RELATIONSHIP())"
        )
        add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{relation},#{shape_of})")

    def _style(self, bodies: Sequence[StepBody]) -> None:
        """A colour and a layer for each body."""
        add = self._add
        styled: list[int] = []
        for body in bodies:
            colour = add(f"COLOUR_RGB('',{reals(body.colour, UNIT_DIGITS)[1:-1]})")
            fill = add(f"FILL_AREA_STYLE_COLOUR('',#{colour})")
            area = add(f"FILL_AREA_STYLE('',(#{fill}))")
            surface = add(f"SURFACE_STYLE_FILL_AREA(#{area})")
            side = add(f"SURFACE_SIDE_STYLE('',(#{surface}))")
            usage = add(f"SURFACE_STYLE_USAGE(.BOTH.,#{side})")
            style = add(f"PRESENTATION_STYLE_ASSIGNMENT((#{usage}))")
            styled.append(add(f"STYLED_ITEM('color',(#{style}),#{body.entity})"))
            add(f"PRESENTATION_LAYER_ASSIGNMENT({text(body.name)},'',(#{body.entity}))")
        add(f"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{refs(styled)},#{self._space})")
