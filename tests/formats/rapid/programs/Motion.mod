MODULE Motion
    ! Motion: what RobotWare knows, never run.
    VAR robtarget p;
    VAR jointtarget j;

    PROC main()
        ConfL\Off;
        SingArea\Wrist;
        AccSet 50,50;
        VelSet 100,800;
        MoveJ p,vmax,fine,tool0\WObj:=wobj0;
        MoveL\Conc,p\ID:=1,v100\V:=2200,z10\Z:=45,tool0\WObj:=wobj0\Corr;
        MoveL ToPoint:=p,Speed:=v100,Zone:=z0,Tool:=tool0;
        MoveC p,RelTool(p,0,0,10\Rx:=5),v50\T:=2,z1\Inpos:=inpos20,tool0\TLoad:=load0;
        MoveAbsJ j\NoEOffs,v1000,z200,tool0;
        MoveExtJ j,vrot10,fine;
        MoveLDO p,v5,z5,tool0,doX,1;
        p.trans:=p.trans*2+[1,2,3]-p.trans/4;
        p.rot:=p.rot*OrientZYX(0,0,90);
        p.trans.x:=EulerZYX(\Z,p.rot);
        WaitRob\InPos;
    ENDPROC
ENDMODULE
